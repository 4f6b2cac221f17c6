# SPDX-License-Identifier: BSD-3-Clause
# cmake -DFILE=... -P GelenkGzip.cmake: writes FILE.gz, with the compressor that CMake has inside.
file(ARCHIVE_CREATE OUTPUT ${FILE}.gz PATHS ${FILE} FORMAT raw COMPRESSION GZip)
