#include "pipeline/point_dealer.h"

#include <numeric>

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
    for (std::size_t s = 0; s < writers_.size(); ++s) {
        if (begin_[s] == begin_[s + 1]) continue;
        block_.position.clear();
        block_.id.clear();
        block_.normal.clear();
        block_.scan.clear();
        for (std::size_t k = begin_[s]; k < begin_[s + 1]; ++k)
            put(chunk, order_[k], first_id, input, s);
        writers_[s].append(block_);
    }
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

void PointDealer::put(const PointChunk& chunk, std::size_t i, std::uint64_t first_id,
                      std::size_t input, std::size_t slice) {
    const Vec3d local = chunk.position[i] - plan_.origin;
    plan_.slices[slice].bounds.extend(local);
    block_.position.push_back(local);
    block_.id.push_back(first_id + i);
    if (plan_.has_normals) {
        const bool good = !chunk.normal.empty() && is_finite(chunk.normal[i]);
        block_.normal.push_back(good ? chunk.normal[i] : Vec3f{});
    }
    if (plan_.has_scans) {
        const std::uint32_t own = chunk.scan.empty() ? 0u : chunk.scan[i];
        block_.scan.push_back(static_cast<std::uint16_t>(plan_.inputs[input].first_scan + own));
    }
}

}  // namespace slim
