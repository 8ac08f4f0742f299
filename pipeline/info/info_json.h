#pragma once

#include "slim/base/bbox.h"
#include "slim/base/vec.h"

#include <nlohmann/json.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>

namespace slim {

nlohmann::json vector_json(const Vec3d& v);

/// Corners in the world, given a box in the local frame; null for an empty one.
nlohmann::json bounds_json(const Bbox& box, const Vec3d& origin = {});

/// A text as the JSON that it is, or else as a string.
nlohmann::json parsed(const std::string& text);

/// Counts by a small number, such as surfels per level: {"1": 12, "2": 40}.
class Tally {
public:
    void add(std::size_t i) { ++counts_[i]; }
    nlohmann::json to_json() const {
        nlohmann::json out = nlohmann::json::object();
        for (std::size_t i = 0; i < counts_.size(); ++i)
            if (counts_[i]) out[std::to_string(i)] = counts_[i];
        return out;
    }

private:
    std::array<std::uint64_t, 256> counts_{};
};

}  // namespace slim
