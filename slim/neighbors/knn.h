#pragma once

#include "slim/base/vec.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace slim {

/// Exact k nearest neighbours (FLANN's single kd-tree, the only exact index it has,
/// CONVENTIONS 4.1).
class KnnIndex {
public:
    /// Keeps a copy of the positions. Cost O(n log n), one thread; 32 bytes a point.
    explicit KnnIndex(std::span<const Vec3d> positions);
    ~KnnIndex();
    KnnIndex(const KnnIndex&) = delete;
    KnnIndex& operator=(const KnnIndex&) = delete;

    std::size_t size() const;
    /// Neighbours of each query, nearest first: k indices and squared distances a query (a query
    /// that is a point of the index finds itself). k is cut to size(); the cut value is returned.
    /// Parallel.
    std::size_t search(std::span<const Vec3d> queries, std::size_t k,
                       std::vector<std::uint32_t>& indices,
                       std::vector<double>& sq_distances) const;

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace slim
