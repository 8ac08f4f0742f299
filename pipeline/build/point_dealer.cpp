#include "pipeline/build/point_dealer.h"

#include "slim/base/parallel.h"

#include <numeric>
#include <span>

namespace slim {

PointDealer::PointDealer(const std::filesystem::path& work, SlicePlan& plan,
                         const BlockPlan& blocks)
    : plan_(plan), blocks_(blocks) {
    for (std::size_t i = 0; i < plan.slices.size(); ++i) {
        std::filesystem::create_directories(slice_folder(work, i));
        writers_.emplace_back(slice_points_path(work, i).string(), plan.origin,
                              plan.slices[i].n_points, plan.has_normals, plan.has_scans);
    }
}

void PointDealer::take(const PointChunk& chunk, std::uint64_t first_id, std::size_t input) {
    sort_by_slice(chunk);
    parallel_blocks(writers_.size(), 1, [&](std::size_t s, std::size_t) {
        if (begin_[s] < begin_[s + 1]) writers_[s].append(points_of(s, chunk, first_id, input));
    });
}

void PointDealer::commit() {
    for (SliceWriter& writer : writers_) writer.commit();
}

/// Fills order_ with the chunk's finite points, those of slice s from begin_[s] on, in their order.
void PointDealer::sort_by_slice(const PointChunk& chunk) {
    slice_of_.assign(chunk.size(), 0);
    begin_.assign(writers_.size() + 1, 0);
    for (std::size_t i = 0; i < chunk.size(); ++i) {
        if (!is_finite(chunk.position[i])) continue;
        slice_of_[i] = blocks_.block_of(chunk.position[i]);
        ++begin_[slice_of_[i] + 1];
    }
    std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
    order_.resize(begin_.back());
    std::vector<std::size_t> at(begin_.begin(), begin_.end() - 1);
    for (std::size_t i = 0; i < chunk.size(); ++i)
        if (is_finite(chunk.position[i])) order_[at[slice_of_[i]]++] = i;
}

/// The chunk's points of a slice, whose bounds they extend.
PointBlock PointDealer::points_of(std::size_t slice, const PointChunk& chunk,
                                  std::uint64_t first_id, std::size_t input) {
    const std::span<const std::size_t> own(&order_[begin_[slice]],
                                           begin_[slice + 1] - begin_[slice]);
    PointBlock out;
    out.position.reserve(own.size());
    out.id.reserve(own.size());
    Bbox& bounds = plan_.slices[slice].bounds;
    for (const std::size_t i : own) {
        const Vec3d local = chunk.position[i] - plan_.origin;
        bounds.extend(local);
        out.position.push_back(local);
        out.id.push_back(first_id + i);
    }
    if (plan_.has_normals) {
        out.normal.reserve(own.size());
        for (const std::size_t i : own) {
            const bool good = !chunk.normal.empty() && is_finite(chunk.normal[i]);
            out.normal.push_back(good ? chunk.normal[i] : Vec3f{});
        }
    }
    if (plan_.has_scans) {
        out.scan.reserve(own.size());
        for (const std::size_t i : own) {
            const std::uint32_t of_input = chunk.scan.empty() ? 0u : chunk.scan[i];
            out.scan.push_back(
                static_cast<std::uint16_t>(plan_.inputs[input].first_scan + of_input));
        }
    }
    return out;
}

}  // namespace slim
