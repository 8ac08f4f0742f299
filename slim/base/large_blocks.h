#pragma once

#include <cstddef>

namespace slim {

// What operator new gives of 1 MiB and more is mapped apart. Freed, it stays with the program and serves the next such
// block, whole or in parts: a new page costs a microsecond or two, which was a sixth of a build of 10 million points.
// Before new pages are mapped, kept ones go until all together are at most four fifths of the most that was in use at
// some time, or what is in use: the peak of the memory stays as it was.
// Not under sanitizers, which watch the heap themselves.

/// Gives what is kept back to the system.
void release_large_blocks();

/// Bytes of large blocks.
struct LargeBlockUse {
    std::size_t in_use, kept, most_in_use;
};
LargeBlockUse large_block_use();

}  // namespace slim
