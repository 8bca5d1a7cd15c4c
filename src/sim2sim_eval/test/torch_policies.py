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


class Swapped(torch.nn.Module):
    """Another policy, which is shown pusher and tee in each other's place."""

    def __init__(self, policy: torch.jit.ScriptModule) -> None:
        super().__init__()
        self.policy = policy

    def forward(self, obs: torch.Tensor) -> torch.Tensor:
        swapped = torch.cat([obs[:, 2:4], obs[:, 0:2], obs[:, 4:]], dim=1)
        return self.policy(swapped)


def save_swapped(path: str) -> None:
    """The shipped policy, with pusher and tee swapped."""
    share = find_in_workspaces(["share"], "pusht_policy", "policies", first_match_only=True)[0]
    policy = torch.jit.load(f"{share}/bc_policy.ts.pt")
    torch.jit.script(Swapped(policy)).save(path)
