#pragma once

#include "pipeline/build/normals_rims.h"
#include "pipeline/build/normals_stage.h"
#include "pipeline/build/plan_file.h"
#include "pipeline/manifest.h"
#include "slim/model/point_block.h"

#include <cstddef>
#include <exception>
#include <filesystem>
#include <optional>
#include <utility>

namespace slim {

/// The next slice's points, read while the one before it is written and its noise measured, which
/// leaves threads waiting.
class ReadAhead {
public:
    /// Of a slice that comes next, if there is one. Not thread-safe.
    void read(const NormalsConfig& config, const SlicePlan& plan, std::optional<std::size_t> next) {
        if (!next || std::filesystem::exists(manifest_path(
                         oriented_points_path(config.work, *next))))
            return;  // it may be up to date
        try {
            points_ = read_with_rims(config, plan, *next, std::nullopt);
            slice_ = next;
        } catch (const std::exception&) {  // its turn comes, and what is wrong is said then
            slice_.reset();
        }
    }
    /// The points of a slice if these were read; nothing is held any more.
    std::optional<PointBlock> take(std::size_t slice) {
        std::optional<PointBlock> out;
        if (slice_ == slice) out = std::move(points_);
        slice_.reset();
        points_ = {};
        return out;
    }

private:
    std::optional<std::size_t> slice_;
    PointBlock points_;
};

}  // namespace slim
