#include "pipeline/build/point_dealer.h"

#include "slim/base/parallel.h"

#include <numeric>
#include <span>

namespace slim {
namespace {

constexpr std::size_t kGrain = 4096;  // points a task

}  // namespace

PointDealer::PointDealer(const std::filesystem::path& work, SlicePlan& plan,
                         const BlockPlan& blocks)
    : plan_(plan), blocks_(blocks) {
    const double width = rim_width(plan);
    for (std::size_t i = 0; i < plan.slices.size(); ++i) {
        writers_.emplace_back(slice_points_path(work, i).string(), plan.origin,
                              plan.slices[i].n_points, plan.has_normals, plan.has_scans);
        Bbox inside = plan.slices[i].region;
        for (std::size_t axis = 0; axis < 3; ++axis)
            inside.lo[axis] += width, inside.hi[axis] -= width;
        inside_.push_back(inside);
    }
}

void PointDealer::take(const PointChunk& chunk, std::uint64_t first_id, std::size_t input) {
    sort_by_part(chunk);
    parallel_blocks(writers_.size(), 1, [&](std::size_t s, std::size_t) {
        for (const auto apart : {SliceWriter::Apart::no, SliceWriter::Apart::yes}) {
            const std::size_t part = 2 * s + (apart == SliceWriter::Apart::yes ? 1 : 0);
            if (begin_[part] < begin_[part + 1])
                writers_[s].append(points_of(part, chunk, first_id, input), apart);
        }
    });
}

void PointDealer::commit() {
    for (SliceWriter& writer : writers_) writer.commit();
}

/// Fills order_ with the chunk's finite points, those of part p from begin_[p] on, in their order.
void PointDealer::sort_by_part(const PointChunk& chunk) {
    part_of_.resize(chunk.size());
    parallel_blocks(chunk.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const Vec3d& p = chunk.position[i];
            if (!is_finite(p)) continue;
            const std::size_t slice = blocks_.block_of(p);
            part_of_[i] = 2 * slice + (is_in(inside_[slice], p - plan_.origin) ? 0 : 1);
        }
    });
    begin_.assign(2 * writers_.size() + 1, 0);
    for (std::size_t i = 0; i < chunk.size(); ++i)
        if (is_finite(chunk.position[i])) ++begin_[part_of_[i] + 1];
    std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
    order_.resize(begin_.back());
    std::vector<std::size_t> at(begin_.begin(), begin_.end() - 1);
    for (std::size_t i = 0; i < chunk.size(); ++i)
        if (is_finite(chunk.position[i])) order_[at[part_of_[i]]++] = i;
}

/// The chunk's points of a part of a slice, whose bounds they extend.
PointBlock PointDealer::points_of(std::size_t part, const PointChunk& chunk,
                                  std::uint64_t first_id, std::size_t input) {
    const std::span<const std::size_t> own(&order_[begin_[part]],
                                           begin_[part + 1] - begin_[part]);
    PointBlock out;
    out.position.reserve(own.size());
    out.id.reserve(own.size());
    Bbox& bounds = plan_.slices[part / 2].bounds;
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
