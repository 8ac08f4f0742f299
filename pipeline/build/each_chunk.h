#pragma once

#include "formats/point_source.h"
#include "slim/base/reporter.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace slim {

inline constexpr std::size_t kChunkPoints = std::size_t{1} << 16;

/// Calls take(chunk, first_id, input) for all chunks of all clouds in order, of at most
/// kChunkPoints; first_id counts all points. face_points: as open_cloud has it. beside(input,
/// n_bytes), if given, is called with each, at the same time: so much of the file is read.
void for_each_chunk(const std::vector<std::string>& paths, Reporter& reporter,
                    const std::string& doing,
                    const std::function<void(const PointChunk&, std::uint64_t first_id,
                                             std::size_t input, const CloudInfo&)>& take,
                    bool face_points = false,
                    const std::function<void(std::size_t input, std::uint64_t n_bytes)>& beside =
                        nullptr);

}  // namespace slim
