#!/bin/sh
# SPDX-License-Identifier: BSD-3-Clause
# sh cmake/jobs.sh [MEMINFO]: prints how many jobs run at once: one for each processor that may be used, fewer where memory
# does not suffice. MEGABYTES is the peak of the largest compiler process: 1,410 with GCC 12, for
# the files of src/derivatives together.
MEGABYTES=1450
# nproc would count the threads that OpenMP may have.
cores=$(unset OMP_NUM_THREADS OMP_THREAD_LIMIT; nproc 2>/dev/null || getconf _NPROCESSORS_ONLN 2>/dev/null || echo 2)
free=$(awk '/^MemAvailable:/ {print int($2 / 1024)}' "${1:-/proc/meminfo}" 2>/dev/null)
[ -n "$free" ] || free=$(($(sysctl -n hw.memsize 2>/dev/null || echo 0) / 2097152))   # macOS: half of what there is
[ "$free" -gt 0 ] || free=$((2 * MEGABYTES))
# A container may have less than the machine.
for limit in /sys/fs/cgroup/memory.max /sys/fs/cgroup/memory/memory.limit_in_bytes; do
  bytes=$(cat "$limit" 2>/dev/null)
  case "$bytes" in
    "" | *[!0-9]*) ;;
    *) [ ${#bytes} -gt 15 ] || [ $((bytes / 1048576)) -ge "$free" ] || free=$((bytes / 1048576)) ;;
  esac
done
jobs=$((free / MEGABYTES))
[ "$jobs" -le "$cores" ] || jobs=$cores
[ "$jobs" -ge 1 ] || jobs=1
echo "$jobs"
