#pragma once

#include <cstddef>
#include <functional>

namespace slim {

/// Told between batches how many of all are done, from one thread; may throw to stop.
using EachBatch = std::function<void(std::size_t done, std::size_t total)>;

/// parallel_blocks() in batches of 4,096; the result of a body that keeps its own by index does not
/// depend on them.
void parallel_batches(std::size_t n, std::size_t grain, const EachBatch& each_batch,
                      const std::function<void(std::size_t begin, std::size_t end)>& body);

}  // namespace slim
