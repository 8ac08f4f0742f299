#pragma once

#include "raytrace/renderer.h"

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

namespace slim {

/// Pixels of a picture that are drawn again with 2 x 2 samples: the pixels that they are in a
/// picture of twice the size. A renderer that is given one leaves out all other pixels of such a
/// picture as if nothing were there.
class SampleMask {
public:
    /// Samples along each side of a pixel.
    static constexpr int kSide = 2;

    /// None, of a part of the picture.
    explicit SampleMask(const PixelWindow& part)
        : part_(part),
          wanted_(static_cast<std::size_t>(part.width) * static_cast<std::size_t>(part.height)) {}

    /// The part, in pixels of the picture.
    const PixelWindow& part() const { return part_; }
    /// 1 where a pixel of the part is wanted; row by row.
    std::vector<std::uint8_t>& wanted() { return wanted_; }
    const std::vector<std::uint8_t>& wanted() const { return wanted_; }

    /// Whether a pixel of the picture is wanted; not outside the part.
    bool has_pixel(int x, int y) const {
        const int px = x - part_.x, py = y - part_.y;
        return px >= 0 && py >= 0 && px < part_.width && py < part_.height && *pixel(x, y) != 0;
    }
    /// The same of a sample, a pixel of the picture of twice the size.
    bool has_sample(int x, int y) const { return has_pixel(x / kSide, y / kSide); }
    /// Of pixels of a row from (x, y) on; 0 outside the part.
    void copy_row(int x, int y, std::span<std::uint8_t> out) const;
    /// Whether any of these samples is.
    bool any_sample(const PixelWindow& samples) const;

    /// Those and all pixels that touch one, as far as the part goes.
    SampleMask grown() const;
    /// The rectangle about all wanted pixels in a window of the picture; width 0 if there is none.
    PixelWindow bounds_in(const PixelWindow& window) const;

private:
    /// One of the part.
    const std::uint8_t* pixel(int x, int y) const {
        return wanted_.data() +
               static_cast<std::size_t>(y - part_.y) * static_cast<std::size_t>(part_.width) +
               static_cast<std::size_t>(x - part_.x);
    }

    /// Whether any of n pixels of a row of the part is wanted.
    bool any_of_row(int x, int y, int n) const {
        const std::uint8_t* const row = pixel(x, y);
        std::uint64_t any = 0, eight;
        int k = 0;
        for (; k + 8 <= n; k += 8) std::memcpy(&eight, row + k, 8), any |= eight;
        for (; k < n; ++k) any |= row[k];
        return any != 0;
    }

    PixelWindow part_;
    std::vector<std::uint8_t> wanted_;
};

/// A window of the picture in its samples.
inline PixelWindow samples_of(const PixelWindow& w) {
    constexpr int k = SampleMask::kSide;
    return {w.x * k, w.y * k, w.width * k, w.height * k};
}

}  // namespace slim
