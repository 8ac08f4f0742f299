#include "slim/neighbors/knn.h"

#include "slim/base/parallel.h"

#include <flann/flann.hpp>

#include <algorithm>

namespace slim {

using FlannTree = flann::KDTreeSingleIndex<flann::L2_Simple<double>>;

struct KnnIndex::Impl {
    std::vector<double> coordinates;
    std::unique_ptr<FlannTree> tree;
    std::size_t n = 0;
};

KnnIndex::KnnIndex(std::span<const Vec3d> positions) : impl_(std::make_unique<Impl>()) {
    impl_->n = positions.size();
    impl_->coordinates.resize(positions.size() * 3);
    for (std::size_t i = 0; i < positions.size(); ++i) {
        impl_->coordinates[3 * i] = positions[i].x;
        impl_->coordinates[3 * i + 1] = positions[i].y;
        impl_->coordinates[3 * i + 2] = positions[i].z;
    }
    if (positions.empty()) return;
    // No reordered copy: the caller's points come in an order near in space, and memory counts.
    impl_->tree = std::make_unique<FlannTree>(
        flann::Matrix<double>(impl_->coordinates.data(), positions.size(), 3),
        flann::KDTreeSingleIndexParams(15, false));
    impl_->tree->buildIndex();
}

KnnIndex::~KnnIndex() = default;

std::size_t KnnIndex::size() const { return impl_->n; }

std::size_t KnnIndex::search(std::span<const Vec3d> queries, std::size_t k,
                             std::vector<std::uint32_t>& indices,
                             std::vector<double>& sq_distances) const {
    k = std::min(k, impl_->n);
    indices.resize(queries.size() * k);
    sq_distances.resize(queries.size() * k);
    if (k == 0) return 0;
    flann::SearchParams params(flann::FLANN_CHECKS_UNLIMITED);
    params.cores = 1;
    parallel_blocks(queries.size(), 4096, [&](std::size_t begin, std::size_t end) {
        const std::size_t rows = end - begin;
        std::vector<double> query(rows * 3);
        for (std::size_t i = 0; i < rows; ++i) {
            const Vec3d& q = queries[begin + i];
            query[3 * i] = q.x, query[3 * i + 1] = q.y, query[3 * i + 2] = q.z;
        }
        std::vector<std::size_t> found(rows * k);
        flann::Matrix<std::size_t> found_matrix(found.data(), rows, k);
        flann::Matrix<double> distance_matrix(sq_distances.data() + begin * k, rows, k);
        impl_->tree->knnSearch(flann::Matrix<double>(query.data(), rows, 3), found_matrix,
                               distance_matrix, k, params);
        std::transform(found.begin(), found.end(),
                       indices.begin() + static_cast<std::ptrdiff_t>(begin * k),
                       [](std::size_t i) { return static_cast<std::uint32_t>(i); });
    });
    return k;
}

}  // namespace slim
