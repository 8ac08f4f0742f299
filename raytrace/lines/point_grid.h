#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace slim {

/// Places of a picture by squares as large as the reach. Adding and asking cost O(1) while places
/// do not crowd.
class PointGrid {
public:
    /// n: about how many are added.
    PointGrid(float reach, std::size_t n) : reach_(reach) {
        std::size_t size = 64;
        while (size < 2 * n) size *= 2;
        heads_.assign(size, kNone);
        places_.reserve(n);
    }

    void add(float x, float y, std::uint32_t value) {
        std::uint32_t& head = heads_[slot(square(x), square(y))];
        places_.push_back({x, y, value, head});
        head = static_cast<std::uint32_t>(places_.size() - 1);
    }

    /// visit(value, squared distance) for each place within reach of one.
    template <class Visit>
    void for_each(float x, float y, Visit&& visit) const {
        const int column = square(x), row = square(y);
        for (int j = row - 1; j <= row + 1; ++j)
            for (int i = column - 1; i <= column + 1; ++i)
                for (std::uint32_t at = heads_[slot(i, j)]; at != kNone; at = places_[at].next) {
                    const Place& p = places_[at];
                    // of another square, in the same slot
                    if (square(p.x) != i || square(p.y) != j) continue;
                    const float sq = (p.x - x) * (p.x - x) + (p.y - y) * (p.y - y);
                    if (sq <= reach_ * reach_) visit(p.value, sq);
                }
    }

private:
    static constexpr std::uint32_t kNone = UINT32_MAX;
    struct Place {
        float x, y;
        std::uint32_t value, next;
    };
    int square(float x) const { return static_cast<int>(std::floor(x / reach_)); }
    std::size_t slot(int i, int j) const {
        const auto key =
            std::uint64_t{static_cast<std::uint32_t>(i)} << 32 | static_cast<std::uint32_t>(j);
        return static_cast<std::size_t>(key * 0x9e3779b97f4a7c15u >> 24) & (heads_.size() - 1);
    }

    float reach_;
    std::vector<std::uint32_t> heads_;
    std::vector<Place> places_;
};

}  // namespace slim
