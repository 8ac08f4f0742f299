#pragma once

#include "formats/slice_file.h"
#include "pipeline/build/cloud_survey.h"
#include "pipeline/build/plan_file.h"
#include "slim/slicing/block_plan.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <vector>

namespace slim {

/// Deals points out to the files of their slices, to several at a time; those that are of other
/// slices' rims into pieces apart, so that rims are read of these alone. Holds the points of one
/// chunk.
class PointDealer {
public:
    /// Sets the bounds of the plan's slices as points come; both must outlive the dealer.
    PointDealer(const std::filesystem::path& work, SlicePlan& plan, const BlockPlan& blocks);

    /// input: the number of the cloud that the chunk is of; first_id: the job's id of its first
    /// point
    void take(const PointChunk& chunk, std::uint64_t first_id, std::size_t input);

    /// Makes the files visible.
    void commit();

private:
    void sort_by_part(const PointChunk& chunk);
    PointBlock points_of(std::size_t part, const PointChunk& chunk, std::uint64_t first_id,
                         std::size_t input);

    SlicePlan& plan_;
    const BlockPlan& blocks_;
    std::vector<SliceWriter> writers_;
    std::vector<Bbox> inside_;  // of each slice: what no other slice's rim reaches
    // Of a chunk; part 2 s is what lies inside of slice s, 2 s + 1 the rest of it.
    std::vector<std::size_t> part_of_, begin_, order_;
};

}  // namespace slim
