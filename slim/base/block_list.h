#pragma once

#include <cstddef>
#include <utility>
#include <vector>

namespace slim {

/// A list that only grows, in blocks of equal size: where a vector that doubles holds up to three times its
/// elements while it moves them, and twice after it, this holds at most one block too many.
template <class T>
class BlockList {
public:
    void push_back(T value) {
        if (blocks_.empty() || blocks_.back().size() == kBlock) {
            blocks_.emplace_back();
            blocks_.back().reserve(kBlock);
        }
        blocks_.back().push_back(std::move(value));
    }
    std::size_t size() const {
        return blocks_.empty() ? 0 : (blocks_.size() - 1) * kBlock + blocks_.back().size();
    }
    /// All elements as one array; the list is empty then. Each block is freed once its elements are moved.
    std::vector<T> take() {
        std::vector<T> all;
        all.reserve(size());
        for (std::vector<T>& block : blocks_) {
            for (T& value : block) all.push_back(std::move(value));
            std::vector<T>().swap(block);  // "= {}" would keep the memory
        }
        blocks_.clear();
        return all;
    }

private:
    static constexpr std::size_t kBlockBytes = std::size_t{1} << 20;  // goes back to the system when freed
    static constexpr std::size_t kBlock = kBlockBytes < sizeof(T) ? 1 : kBlockBytes / sizeof(T) + 1;

    std::vector<std::vector<T>> blocks_;
};

}  // namespace slim
