# SPDX-License-Identifier: BSD-3-Clause
"""Policies on libtorch, for tests. Apart, because importing torch takes a second."""

import torch
from catkin.find_in_workspaces import find_in_workspaces  # type: ignore[import]


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


def save_swapped(path: str) -> None:
    """The shipped policy, which is shown pusher and tee in each other's place."""
    share = find_in_workspaces(["share"], "pusht_policy", "policies", first_match_only=True)[0]
    swap = torch.nn.Linear(10, 10, bias=False)
    with torch.no_grad():
        swap.weight.copy_(torch.eye(10)[[2, 3, 0, 1, 4, 5, 6, 7, 8, 9]])
    policy = torch.nn.Sequential(swap, torch.jit.load(f"{share}/bc_policy.ts.pt"))
    torch.jit.script(policy.eval()).save(path)
