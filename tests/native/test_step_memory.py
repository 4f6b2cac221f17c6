# SPDX-License-Identifier: BSD-3-Clause
"""Memory from which the steps of an FMU are served (fmu/step_memory.h)."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import pytest

REGION = 4 << 20  # bytes

# On either side of each kind of border between sizes of blocks.
SIZES = [0, 1, 8, 15, 16, 17, 32, 33, 1008, 1009, 1023, 1024, 1025, 1279, 1280, 1281, 1536, 1537, 1792, 1793,
         2048, 2049, 4096, 4097, 65535, 65536, 65537, 100000, 500000]  # fmt: skip


def test_blocks_hold_what_was_asked_for(units: Any) -> None:
    memory = units.StepMemory()
    taken = {}
    for n in SIZES:
        block = memory.take(n)
        assert block % 16 == 0
        size = units.step_memory_size(block)
        assert n <= size <= max(16, n + 15, 1.25 * n)
        assert units.filled(block, size)
        taken[block] = size
    ends = sorted((block, block + size) for block, size in taken.items())
    assert all(a[1] <= b[0] for a, b in pairwise(ends))
    assert all(units.step_memory_release(block) for block in taken)


@pytest.mark.parametrize("n", SIZES)
def test_a_block_given_back_is_taken_again(units: Any, n: int) -> None:
    """Any number of times: what steps need for a while does not add up."""
    memory = units.StepMemory()
    block = memory.take(n)
    for _ in range(1000):
        assert units.step_memory_release(block)
        assert memory.take(n) == block
    units.step_memory_release(block)


def test_without_an_instance_nothing_is_served(units: Any) -> None:
    assert units.step_memory_take_unused() == 0
    heap = units.heap_block()
    assert units.step_memory_size(heap) == 0
    assert not units.step_memory_release(heap)
    units.free_heap_block(heap)


def test_what_is_too_large_or_too_much_comes_from_the_heap(units: Any) -> None:
    """Until then blocks of the heap that are freed in steps are kept; afterwards they would add up."""
    memory = units.StepMemory()
    assert memory.keep(units.heap_block())
    half = units.StepMemory()
    assert units.step_memory_release(half.take(REGION // 2))
    assert memory.take(REGION // 2 + 1) == 0
    blocks = []
    while block := memory.take(REGION // 64):
        blocks.append(block)
    assert 50 < len(blocks) < 64
    heap = units.heap_block()
    assert not memory.keep(heap)
    units.free_heap_block(heap)
    for block in blocks:
        assert units.step_memory_release(block)
    assert memory.take(REGION // 64) in blocks


def test_blocks_outlive_their_instance(units: Any) -> None:
    memory, other = units.StepMemory(), units.StepMemory()
    blocks = [memory.take(n) for n in (100, 2000)]
    memory.go()
    assert all(units.filled(block, 100) for block in blocks)
    beside = other.take(100)
    assert all(units.step_memory_release(block) for block in blocks)
    assert not units.step_memory_release(blocks[0])  # now it is no memory of steps
    assert units.step_memory_release(beside)


def test_many_instances_have_their_own(units: Any) -> None:
    memories = [units.StepMemory() for _ in range(300)]
    blocks = [memory.take(1000) for memory in memories]
    served = [block for block in blocks if block]
    assert len(served) > 250  # beyond what the table of regions holds at an address, the heap serves
    assert len(set(served)) == len(served)
    assert all(units.step_memory_release(block) for block in served)
