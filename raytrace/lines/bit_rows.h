#pragma once

#include "slim/base/simd.h"

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

namespace slim {

/// All lanes.
inline constexpr std::uint32_t kAllLanes = static_cast<std::uint32_t>((1ull << kLanes) - 1);

/// One bit a pixel, read for as many neighbours of a row as there are lanes, from any column on.
/// Around the picture lie `margin` rows and columns of zeros.
class BitRows {
public:
    BitRows(std::size_t width, std::size_t height, std::size_t margin)
        : margin_(margin),
          stride_((width + 2 * margin + kLanes) / 8 + sizeof(std::uint32_t)),
          bytes_(stride_ * (height + 2 * margin), 0) {}

    /// Those of columns x, x + 1, ...; -margin <= x < width + margin, rows likewise.
    std::uint32_t at(std::ptrdiff_t y, std::ptrdiff_t x) const {
        const Place place(*this, y, x);
        return (load(place.byte) >> place.shift) & kAllLanes;
    }
    /// Sets bits. Rows are apart: each may be written by another thread.
    void add(std::ptrdiff_t y, std::ptrdiff_t x, std::uint32_t bits) {
        const Place place(*this, y, x);
        const std::uint32_t word = load(place.byte) | bits << place.shift;
        std::memcpy(bytes_.data() + place.byte, &word, sizeof word);
    }

private:
    static_assert(kLanes + 7 <= 32);
    struct Place {
        std::size_t byte;
        unsigned shift;
        Place(const BitRows& rows, std::ptrdiff_t y, std::ptrdiff_t x) {
            const auto margin = static_cast<std::ptrdiff_t>(rows.margin_);
            const auto bit = static_cast<std::size_t>(x + margin);
            byte = static_cast<std::size_t>(y + margin) * rows.stride_ + bit / 8, shift = bit % 8;
        }
    };
    std::uint32_t load(std::size_t byte) const {
        std::uint32_t word;
        std::memcpy(&word, bytes_.data() + byte, sizeof word);
        return word;
    }

    std::size_t margin_, stride_;
    std::vector<std::uint8_t> bytes_;
};

/// visit(k) for each bit that is set, lowest first.
template <class Visit>
void for_each_bit(std::uint32_t bits, Visit&& visit) {
    for (; bits != 0; bits &= bits - 1) visit(static_cast<std::size_t>(std::countr_zero(bits)));
}

}  // namespace slim
