#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""An untrained PyTorch module as a policy: it looks back on two observations, and plans 8 steps."""

import sim2sim
import torch

torch.manual_seed(0)
network = torch.nn.Sequential(torch.nn.Flatten(), torch.nn.Linear(2 * 10, 64), torch.nn.Tanh())
network.extend([torch.nn.Linear(64, 8 * 2), torch.nn.Unflatten(1, (8, 2))])

print(sim2sim.compare(network, history=2, execute=4, episodes=20))
