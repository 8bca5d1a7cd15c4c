# SPDX-License-Identifier: BSD-3-Clause
"""Policies on libtorch, for tests. Apart, because importing torch takes a second."""

import torch


class Charge(torch.nn.Module):
    """Drives into the tee at full speed, which a soft link does not survive."""

    def forward(self, obs: torch.Tensor) -> torch.Tensor:
        return torch.clamp(100.0 * (obs[:, 2:4] - obs[:, 0:2]), -1.0, 1.0)


class Endless(torch.nn.Module):
    """To the right, and without end where x is from `low` to `high`."""

    def __init__(self, low: float, high: float) -> None:
        super().__init__()
        self.low = low
        self.high = high

    def forward(self, obs: torch.Tensor) -> torch.Tensor:
        x = obs[:, :1]
        endless = bool(((x > self.low) & (x < self.high)).any())
        if endless:
            print("never returns")
        while endless:
            x = x + 0.0
        return torch.cat([torch.ones_like(x), torch.zeros_like(x)], dim=1)


def save_charging(path: str) -> None:
    torch.jit.script(Charge()).save(path)
