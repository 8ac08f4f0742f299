#include "raytrace/project/picked_pixels.h"

#include "slim/blend/blend.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace slim {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
/// Columns of lanes without a pixel: far from every surfel's, and finite.
constexpr float kNowhere = 1e6f;

/// The blocks of a tile along Morton's curve: pixels of few blocks lie near each other.
constexpr auto kNearEachOther = [] {
    std::array<int, kTileBlocks> order{};
    std::size_t n = 0;
    for (int m = 0; n < kTileBlocks; ++m) {
        int x = 0, y = 0;
        for (int bit = 0; bit < 8; ++bit)
            x |= (m >> (2 * bit) & 1) << bit, y |= (m >> (2 * bit + 1) & 1) << bit;
        if (x < kBlockColumns && y < kBlockRows) order[n++] = y * kBlockColumns + x;
    }
    return order;
}();

FloatV::mask_type in_doubt(const TileBuffers& t, std::size_t i) {
    return has_hit(t.z.load(i)) && is_in_doubt<FloatV>(t.weight.load(i));
}

/// visit(of) for the planes of a hit and its sums, as the picture wants them; of(tile) is the
/// plane of a tile.
template <class Visit>
void for_each_plane(const TileSums& sums, Visit&& visit) {
    using T = TileBuffers;
    for (auto plane : {&T::z, &T::gx, &T::gy, &T::gz, &T::weight, &T::sum_x, &T::sum_y, &T::sum_z})
        visit([plane](auto& t) -> auto& { return t.*plane; });
    if (sums.depth) visit([](auto& t) -> auto& { return t.offset; });
    if (sums.count) visit([](auto& t) -> auto& { return t.count; });
    if (sums.node) visit([](auto& t) -> auto& { return t.winner; });
    for (std::size_t n = 0; sums.hessian && n < 6; ++n)
        visit([n](auto& t) -> auto& { return t.hessian[n]; });
    for (std::size_t n = 0; sums.third && n < 10; ++n)
        visit([n](auto& t) -> auto& { return t.third[n]; });
}

}  // namespace

PickedPixels::PickedPixels(const PixelView& view, const TileBuffers& tile) {
    t.x0 = tile.x0, t.y0 = tile.y0, t.clip = tile.clip;
    t.depths = tile.depths, t.near_z = tile.near_z;
    t.places = {columns_.data(), rows_.data(), kTileBlocks - 1, 0};
    t.counts = {};
    for (const int block : kNearEachOther) {
        const auto i = static_cast<std::size_t>(block * kLanes);
        const auto picked = in_doubt(tile, i);
        for (std::uint64_t bits = lane_bits(picked); bits != 0; bits &= bits - 1)
            pick(tile, i + static_cast<std::size_t>(std::countr_zero(bits)));
    }
    fill_directions(view);
    fill_up();
    std::fill_n(t.passing.v, n_blocks() * kLanes, 0.0f);
}

void PickedPixels::fill_up() {
    for (auto k = static_cast<std::size_t>(n_); k < static_cast<std::size_t>(n_blocks() * kLanes);
         ++k) {
        columns_[k] = rows_[k] = kNowhere;
        t.z.v[k] = -kInfinity, t.weight.v[k] = t.last_z.v[k] = 0;
        t.gx.v[k] = t.gy.v[k] = 0, t.gz.v[k] = 1;
        t.dx.v[k] = t.dy.v[k] = 0, t.dz.v[k] = t.inv_dz.v[k] = 1;
    }
}

void PickedPixels::pick(const TileBuffers& tile, std::size_t entry) {
    const auto to = static_cast<std::size_t>(n_++), lane = entry % kLanes;
    const auto block = static_cast<int>(entry / kLanes);
    entry_[to] = static_cast<std::uint16_t>(entry);
    columns_[to] = tile.places.columns_of(block)[lane];
    rows_[to] = tile.places.rows_of(block)[lane];
    t.z.v[to] = tile.z.v[entry], t.weight.v[to] = tile.weight.v[entry];
    t.gx.v[to] = tile.gx.v[entry], t.gy.v[to] = tile.gy.v[entry], t.gz.v[to] = tile.gz.v[entry];
}

void PickedPixels::fill_directions(const PixelView& view) {
    const double per_px = view.orthographic ? 0 : 1 / view.focal_px;
    for (std::size_t k = 0; k < static_cast<std::size_t>(n_); ++k) {
        const double x = (static_cast<double>(columns_[k]) + t.x0 + 0.5 - view.center_x) * per_px,
                     y = (static_cast<double>(rows_[k]) + t.y0 + 0.5 - view.center_y) * per_px;
        const double length = std::sqrt(x * x + y * y + 1);
        t.dx.v[k] = static_cast<float>(x / length), t.dy.v[k] = static_cast<float>(y / length);
        t.dz.v[k] = static_cast<float>(1 / length), t.inv_dz.v[k] = static_cast<float>(length);
    }
}

BlockMask PickedPixels::within(float x, float y, float radius) const {
    BlockMask blocks;
    for (int block = 0; block < n_blocks(); ++block) {
        const FloatV dx = t.places.column(block) - x, dy = t.places.row(block) - y;
        if (stdx::any_of(dx * dx + dy * dy <= radius * radius))
            blocks.add(static_cast<std::size_t>(block), 1);
    }
    return blocks;
}

BlockMask PickedPixels::all() const {
    BlockMask blocks;
    for (int block = 0; block < n_blocks(); ++block) blocks.add(static_cast<std::size_t>(block), 1);
    return blocks;
}

void PickedPixels::find_depths() {
    for (int block = 0; block < n_blocks(); ++block) {
        const FloatV z = t.z.load(static_cast<std::size_t>(block * kLanes));
        const auto k = static_cast<std::size_t>(block);
        near_[k] = stdx::hmin(select<FloatV>(has_hit(z), z, FloatV(kInfinity)));
        far_[k] = stdx::hmax(select<FloatV>(has_hit(z), z, FloatV(-kInfinity)));
    }
}

void PickedPixels::move(std::size_t from, std::size_t to) {
    columns_[to] = columns_[from], rows_[to] = rows_[from], entry_[to] = entry_[from];
    t.last_z.v[to] = t.z.v[from];
    for (auto plane : {&TileBuffers::dx, &TileBuffers::dy, &TileBuffers::dz, &TileBuffers::inv_dz})
        (t.*plane).v[to] = (t.*plane).v[from];
}

bool PickedPixels::leave_outvoted(const TileSums& sums) {
    std::size_t n = 0;
    for (int block = 0; block < n_blocks(); ++block) {
        const auto i = static_cast<std::size_t>(block * kLanes);
        const auto outvoted =
            in_doubt(t, i) && is_outvoted<FloatV>(t.weight.load(i), t.passing.load(i));
        for (std::uint64_t bits = lane_bits(outvoted); bits != 0; bits &= bits - 1)
            move(i + static_cast<std::size_t>(std::countr_zero(bits)), n++);
    }
    if (n == 0) return false;
    n_ = static_cast<int>(n);
    least_last_z_ = *std::min_element(t.last_z.v, t.last_z.v + n);
    for (std::size_t i = 0; i < static_cast<std::size_t>(n_blocks() * kLanes); i += kLanes) {
        for_each_plane(sums, [&](auto&& of) { of(t).store(i, FloatV(0.0f)); });
        t.z.store(i, FloatV(kInfinity));
        t.passing.store(i, FloatV(0.0f));
    }
    fill_up();
    return true;
}

void PickedPixels::put_back(const TileSums& sums, TileBuffers& tile) const {
    for_each_plane(sums, [&](auto&& of) {
        for (std::size_t k = 0; k < static_cast<std::size_t>(n_); ++k)
            of(tile).v[entry_[k]] = of(t).v[k];
    });
}

}  // namespace slim
