# SPDX-License-Identifier: BSD-3-Clause
"""The contract of served simulators and policies: test suites to run over yours.

`simulator_contract` and `policy_contract` have what every simulator and every policy must do,
whatever its language. The modules whose names begin with `own_` add what the nodes of this suite
do besides; a node of yours need not.

In a .test file, beside the node under test:

    <test test-name="mine" pkg="pusht_testing" type="simulator_contract">
      <param name="simulator" value="/mine"/>
    </test>

By hand: rosrun pusht_testing simulator_contract --text _simulator:=/mine
"""
