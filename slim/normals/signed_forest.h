#pragma once

#include <cstddef>
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

namespace slim {

/// Union-find whose members carry a sign relative to their root.
class SignedForest {
public:
    explicit SignedForest(std::size_t n) : parent_(n), flipped_(n, false), size_(n, 1) {
        std::iota(parent_.begin(), parent_.end(), 0u);
    }
    struct Root {
        std::uint32_t index;
        bool flipped;
    };
    Root find(std::uint32_t i) {
        std::uint32_t root = i;
        bool sign = false;
        while (parent_[root] != root) {
            sign ^= flipped_[root];
            root = parent_[root];
        }
        compress(i, root, sign);
        return {root, sign};
    }
    /// Joins the trees of a and b so that their signs differ iff `opposed`; false if joined before.
    bool join(std::uint32_t a, std::uint32_t b, bool opposed) {
        Root ra = find(a), rb = find(b);
        if (ra.index == rb.index) return false;
        if (size_[ra.index] < size_[rb.index]) std::swap(ra, rb);
        parent_[rb.index] = ra.index;
        flipped_[rb.index] = ra.flipped ^ rb.flipped ^ opposed;
        size_[ra.index] += size_[rb.index];
        return true;
    }

private:
    void compress(std::uint32_t i, std::uint32_t root, bool sign) {
        while (parent_[i] != root && i != root) {
            const std::uint32_t next = parent_[i];
            const bool own = flipped_[i];
            parent_[i] = root;
            flipped_[i] = sign;
            sign ^= own;
            i = next;
        }
    }
    std::vector<std::uint32_t> parent_;
    std::vector<bool> flipped_;
    std::vector<std::uint32_t> size_;
};

}  // namespace slim
