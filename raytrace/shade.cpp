#include "raytrace/shade.h"

#include "raytrace/eye_surface.h"
#include "raytrace/whole_power.h"
#include "slim/base/parallel.h"
#include "slim/base/simd.h"

#include <algorithm>
#include <array>
#include <bit>
#include <vector>

namespace slim {
namespace {

FloatV clamp_lanes(const FloatV& x) { return stdx::min(stdx::max(x, FloatV(0.0f)), FloatV(1.0f)); }

/// Some pixels: normals in camera axes and directions to the eye.
struct PixelLanes {
    int n;
    std::uint32_t hit;  ///< a bit each
    LanesOfVec normal, toward_eye;
};

struct Place {
    int x, y;
};

/// The first n of some floats; zeros then.
FloatV load_some(const float* from, int n) {
    if (n == kLanes) return FloatV(from, stdx::element_aligned);
    alignas(64) std::array<float, kLanes> in{};
    std::copy_n(from, n, in.begin());
    return FloatV(in.data(), stdx::vector_aligned);
}

PixelLanes load_lanes(const EyeSurface& surface, int x, int y) {
    const std::size_t i = surface.index(x, y);
    // without a hit the vectors stay as they are: setting them first cost a quarter of the time
    PixelLanes p;
    p.n = std::min(kLanes, surface.width - x);
    p.hit = bits_of_bytes(&surface.hit[i], static_cast<std::size_t>(p.n));
    if (p.hit == 0) return p;
    const NormalPlanes& n = surface.normals;
    p.normal = surface.frame
                   .from_world(LanesOfVec{load_some(&n.x[i], p.n), load_some(&n.y[i], p.n),
                                          load_some(&n.z[i], p.n)})
                   .unit();
    p.toward_eye = surface.frame.toward_eye(surface.frame.across(x),
                                            2 / static_cast<float>(surface.frame.whole_width),
                                            surface.frame.upwards(y));
    return p;
}

/// Silhouettes are few: one by one. place(lane) is where a pixel is.
template <class PlaceOf>
void turn_to_eye(const EyeSurface& surface, const PlaceOf& place, PixelLanes& p) {
    const auto away = static_cast<std::uint32_t>(lane_bits(p.normal.dot(p.toward_eye) < 0.0f));
    for (std::uint32_t bits = away & p.hit; bits != 0; bits &= bits - 1) {
        const int lane = std::countr_zero(bits);
        const Place at = place(lane);
        p.normal.set(lane,
                     surface.eye_normal(at.x, at.y, p.normal.at(lane), p.toward_eye.at(lane)));
    }
}

/// Blinn's highlight of the key light, fading in with n.l so that it cannot shine on the dark side.
FloatV highlight(const Lighting& l, const PixelLanes& p, const FloatV& facing_key) {
    const LanesOfVec half = (p.toward_eye + LanesOfVec(l.key.toward)).unit();
    const FloatV facing = clamp_lanes(4.0f * facing_key);
    return l.specular * facing *
           whole_power(stdx::max(FloatV(0.0f), p.normal.dot(half)), l.shininess);
}

/// Light that the pixels send to the eye, linear; 0 without a hit.
LanesOfVec reflected(const Lighting& l, const PixelLanes& p) {
    const FloatV upward = 0.5f * (1.0f + p.normal.y), downward = 1.0f - upward;
    const FloatV at_key = p.normal.dot(l.key.toward);
    const FloatV key = stdx::max(FloatV(0.0f), at_key);
    const FloatV fill = stdx::max(FloatV(0.0f), p.normal.dot(l.fill.toward));
    const FloatV shine = highlight(l, p, at_key);
    const auto hit = lanes_of_bits(p.hit);
    const auto channel = [&](std::size_t c) {
        const FloatV diffuse = upward * l.sky[c] + downward * l.ground[c] + key * l.key.color[c] +
                               fill * l.fill.color[c];
        return select<FloatV>(hit, l.albedo[c] * diffuse + l.key.color[c] * shine, FloatV(0.0f));
    };
    return {channel(0), channel(1), channel(2)};
}

void store_lanes(const LanesOfVec& color, const FloatV& alpha, int n, float* rgba) {
    if (n == kLanes) return store_interleaved(color.x, color.y, color.z, alpha, rgba);
    std::array<float, 4 * kLanes> some;
    store_interleaved(color.x, color.y, color.z, alpha, some.data());
    std::copy_n(some.begin(), 4 * n, rgba);
}

[[gnu::flatten]] void shade_lanes(const EyeSurface& surface, const Lighting& lighting, int x, int y,
                                  float* rgba) {
    PixelLanes p = load_lanes(surface, x, y);
    if (p.hit == 0) {
        // stored as colours are: g++ 12 makes a slow string instruction of a fill
        const FloatV zero(0.0f);
        return store_lanes({zero, zero, zero}, zero, p.n, rgba);
    }
    turn_to_eye(surface, [&](int lane) { return Place{x + lane, y}; }, p);
    store_lanes(reflected(lighting, p),
                select<FloatV>(lanes_of_bits(p.hit), FloatV(1.0f), FloatV(0.0f)), p.n, rgba);
}

/// Hits that are gathered from where few are: no lane is spent on what is none.
class SparseLanes {
public:
    SparseLanes(const EyeSurface& surface, const Lighting& lighting)
        : surface_(surface), lighting_(lighting) {}

    /// The pixel at (x, y), which has a hit.
    void add(int x, int y, float* rgba) {
        const auto k = static_cast<std::size_t>(n_);
        const std::size_t i = surface_.index(x, y);
        const NormalPlanes& n = surface_.normals;
        at_[k] = {x, y}, rgba_[k] = rgba;
        // As load_lanes has it.
        const int first = x / kLanes * kLanes;
        number_[0][k] = surface_.frame.across(first);
        number_[1][k] = static_cast<float>(x - first);
        number_[2][k] = surface_.frame.upwards(y);
        number_[3][k] = n.x[i], number_[4][k] = n.y[i], number_[5][k] = n.z[i];
        if (++n_ == kLanes) shade();
    }
    /// What is left of those added.
    [[gnu::flatten]] void shade() {
        if (n_ == 0) return;
        const auto load = [&](std::size_t of) {
            return FloatV(number_[of].data(), stdx::vector_aligned);
        };
        const EyeFrame& frame = surface_.frame;
        PixelLanes p;
        p.n = n_, p.hit = (std::uint32_t{1} << n_) - 1;
        p.normal = frame.from_world(LanesOfVec{load(3), load(4), load(5)}).unit();
        p.toward_eye = frame.toward_eye(load(0), load(1),
                                        2 / static_cast<float>(frame.whole_width), load(2));
        turn_to_eye(surface_, [&](int lane) { return at_[static_cast<std::size_t>(lane)]; }, p);
        alignas(64) std::array<float, 4 * kLanes> some;
        const LanesOfVec color = reflected(lighting_, p);
        store_interleaved(color.x, color.y, color.z, FloatV(1.0f), some.data());
        for (std::size_t k = 0; k < static_cast<std::size_t>(n_); ++k)
            std::copy_n(&some[4 * k], 4, rgba_[k]);
        n_ = 0;
    }

private:
    static_assert(kLanes < 32);

    const EyeSurface& surface_;
    const Lighting& lighting_;
    int n_ = 0;
    std::array<Place, kLanes> at_;
    std::array<float*, kLanes> rgba_;
    alignas(64) std::array<std::array<float, kLanes>, 6> number_{};
};

/// Rows of which few pixels have a hit.
void shade_sparse(const EyeSurface& surface, const Lighting& lighting, const RowRange& rows,
                  Picture& out) {
    std::fill(out.rgba.begin(), out.rgba.end(), 0.0f);
    SparseLanes lanes(surface, lighting);
    for (int y = rows.begin; y < rows.end; ++y)
        for (int x = 0; x < surface.width; ++x)
            if (surface.hit[surface.index(x, y)]) lanes.add(x, y, out.pixel(x, y - rows.begin));
    lanes.shade();
}

}  // namespace

Picture shade(int width, int height, const ShadeView& view, const NormalPlanes& normals,
              std::span<const std::uint8_t> hit, const Lighting& lighting) {
    return shade_rows(width, height, view, normals, hit, {0, height}, lighting);
}

Picture shade_rows(int width, int height, const ShadeView& view, const NormalPlanes& normals,
                   std::span<const std::uint8_t> hit, const RowRange& rows,
                   const Lighting& lighting) {
    Picture out;
    shade_rows(width, height, view, normals, hit, rows, lighting, out);
    return out;
}

void shade_rows(int width, int height, const ShadeView& view, const NormalPlanes& normals,
                std::span<const std::uint8_t> hit, const RowRange& rows, const Lighting& lighting,
                Picture& out) {
    check_planes(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), height, rows,
                 normals, hit);
    out.width = width, out.height = rows.end - rows.begin;
    out.rgba.resize(4 * out.n_pixels());
    const EyeFrame frame(view, width, height);
    const EyeSurface surface{width, height, frame, normals, hit};
    if (view.around) return shade_sparse(surface, lighting, rows, out);
    const auto n_rows = static_cast<std::size_t>(out.height);
    parallel_blocks(n_rows, kShadedRows, [&](std::size_t begin, std::size_t end) {
        for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y)
            for (int x = 0; x < width; x += kLanes)
                shade_lanes(surface, lighting, x, rows.begin + y, out.pixel(x, y));
    });
}

void composite_over(const Background& background, Picture& picture, int first_row,
                    int whole_height) {
    const auto rows = static_cast<float>(whole_height > 0 ? whole_height : picture.height);
    for (int y = 0; y < picture.height; ++y) {
        const float t = (static_cast<float>(first_row + y) + 0.5f) / rows;
        const Vec3f c = background.top * (1 - t) + background.bottom * t;
        for (int x = 0; x < picture.width; ++x) {
            float* p = picture.pixel(x, y);
            const float through = background.alpha * (1 - p[3]);
            p[0] += through * c.x, p[1] += through * c.y, p[2] += through * c.z, p[3] += through;
        }
    }
}

}  // namespace slim
