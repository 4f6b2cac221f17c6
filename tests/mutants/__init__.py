# SPDX-License-Identifier: BSD-3-Clause
"""Mutants: the suite against thresholds, guards and fall-backs that were changed at random.

`make mutants COUNT=40 SEED=1` draws places before any test is looked at, changes one at a time and runs the
tests; a mutant that no test notices is named. Only a study can do so: each mutant costs a build and, if it
survives, the whole suite.
"""
