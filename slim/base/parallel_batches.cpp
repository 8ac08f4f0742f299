#include "slim/base/parallel_batches.h"

#include "slim/base/parallel.h"

#include <algorithm>

namespace slim {

void parallel_batches(std::size_t n, std::size_t grain, const EachBatch& each_batch,
                      const std::function<void(std::size_t begin, std::size_t end)>& body) {
    constexpr std::size_t kBatch = 4096;
    for (std::size_t first = 0; first < n; first += kBatch) {
        const std::size_t count = std::min(kBatch, n - first);
        parallel_blocks(count, grain, [&](std::size_t begin, std::size_t end) {
            body(first + begin, first + end);
        });
        if (each_batch) each_batch(first + count, n);
    }
}

}  // namespace slim
