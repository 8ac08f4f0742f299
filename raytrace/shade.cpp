#include "raytrace/shade.h"

#include "slim/base/check.h"
#include "slim/base/parallel.h"
#include "slim/base/simd.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <vector>

namespace slim {
namespace {

constexpr std::size_t kRowGrain = 8;

/// Vectors of some pixels.
struct Vec3V {
    FloatV x, y, z;

    FloatV dot(const Vec3V& b) const { return x * b.x + y * b.y + z * b.z; }
    FloatV dot(const Vec3f& b) const { return x * b.x + y * b.y + z * b.z; }
    Vec3f at(int lane) const {
        const auto k = static_cast<std::size_t>(lane);
        return {x[k], y[k], z[k]};
    }
    void set(int lane, const Vec3f& v) {
        const auto k = static_cast<std::size_t>(lane);
        x[k] = v.x, y[k] = v.y, z[k] = v.z;
    }
};

/// A vector of length 0 stays one.
Vec3V unit_lanes(const Vec3V& v) {
    const FloatV scale = inverse_sqrt(stdx::max(v.dot(v), FloatV(std::numeric_limits<float>::min())));
    return {v.x * scale, v.y * scale, v.z * scale};
}

FloatV clamp_lanes(const FloatV& x) { return stdx::min(stdx::max(x, FloatV(0.0f)), FloatV(1.0f)); }

/// By squares and products: of 36 six products, relative error below 1e-5.
FloatV power_lanes(FloatV base, int exponent) {
    FloatV product(1.0f);
    for (; exponent > 0; exponent >>= 1, base = base * base)
        if (exponent & 1) product = product * base;
    return product;
}

float screen_coordinate(int pixel, int n) {
    return (static_cast<float>(pixel) + 0.5f) * 2 / static_cast<float>(n) - 1;
}

/// The camera's axes in floats, and the direction from a pixel's surface to the eye in those axes.
struct EyeFrame {
    Vec3f right, up, back;
    float half_width, half_height;
    bool orthographic;
    int first_x, first_y, whole_width, whole_height;

    EyeFrame(const ShadeView& v, int width, int height)
        : right(to_float(v.right)),
          up(to_float(v.up)),
          back(to_float(v.back)),
          half_width(static_cast<float>(v.half_width)),
          half_height(static_cast<float>(v.half_height)),
          orthographic(v.orthographic),
          first_x(v.first_x),
          first_y(v.first_y),
          whole_width(v.whole_width > 0 ? v.whole_width : width),
          whole_height(v.whole_height > 0 ? v.whole_height : height) {}

    Vec3f from_world(const Vec3f& d) const { return {dot(right, d), dot(up, d), dot(back, d)}; }
    Vec3V from_world(const Vec3V& d) const { return {d.dot(right), d.dot(up), d.dot(back)}; }

    /// Column x and row y of the planes in [-1, 1] over the whole picture, rightwards and upwards.
    float across(int x) const { return screen_coordinate(first_x + x, whole_width); }
    float upwards(int y) const { return -screen_coordinate(first_y + y, whole_height); }

    /// s, t in [-1, 1] over the picture, t upwards.
    Vec3f toward_eye(float s, float t) const {
        if (orthographic) return {0, 0, 1};
        return normalized(Vec3f{-s * half_width, -t * half_height, 1});
    }
    /// The same at s, s + step, ...
    Vec3V toward_eye(float s, float step, float t) const {
        if (orthographic) return {FloatV(0.0f), FloatV(0.0f), FloatV(1.0f)};
        const FloatV lane([](auto k) { return static_cast<float>(k); });
        const FloatV across = -half_width * (s + lane * step);
        return unit_lanes({across, FloatV(-t * half_height), FloatV(1.0f)});
    }
};

constexpr float kTurnedRound = 0.5f;  ///< from -n . e on no silhouette

/// The planes of a whole picture in camera axes.
struct Surface {
    int width, height;
    const EyeFrame& frame;
    const NormalPlanes& normals;
    std::span<const std::uint8_t> hit;

    std::size_t index(int x, int y) const {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
               static_cast<std::size_t>(x);
    }

    Vec3f raw_normal(std::size_t i) const {
        return normalized(frame.from_world(Vec3f{normals.x[i], normals.y[i], normals.z[i]}));
    }

    bool faces(int x, int y, const Vec3f& toward_eye) const {
        if (x < 0 || y < 0 || x >= width || y >= height) return false;
        const std::size_t i = index(x, y);
        return hit[i] && dot(raw_normal(i), toward_eye) > 0;
    }

    /// Whether a pixel in one of eight directions faces the eye; the nearest are asked first.
    bool is_near_front(int x, int y, const Vec3f& toward_eye) const {
        const int reach = shade_reach(frame.whole_width, frame.whole_height);
        for (int r = 1; r <= reach; ++r)
            for (int dy = -r; dy <= r; dy += r)
                for (int dx = -r; dx <= r; dx += r)
                    if (faces(x + dx, y + dy, toward_eye)) return true;
        return false;
    }

    /// The normal n of one pixel, turned to the eye; zero where the renderer had none.
    Vec3f eye_normal(int x, int y, const Vec3f& n, const Vec3f& toward_eye) const {
        const float away = -dot(n, toward_eye);
        if (!(away > 0)) return n;
        if (away >= kTurnedRound || !is_near_front(x, y, toward_eye)) return -n;
        return silhouette_normal(n, toward_eye);
    }
};

void check_planes(std::size_t n_pixels, int height, const RowRange& rows, const NormalPlanes& normals,
                  std::span<const std::uint8_t> hit) {
    SLIM_CHECK(hit.size(), ==, n_pixels);
    SLIM_CHECK(std::min({normals.x.size(), normals.y.size(), normals.z.size()}), ==, n_pixels);
    SLIM_CHECK(rows.begin, >=, 0);
    SLIM_CHECK(rows.end, <=, height);
}

/// Calls pixel(i, n, toward_eye) at every hit of some rows, in parallel; i counts from their first.
template <class Body>
void for_hits(int width, int height, const RowRange& rows, const ShadeView& view,
              const NormalPlanes& normals, std::span<const std::uint8_t> hit, const Body& pixel) {
    const auto n_pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    check_planes(n_pixels, height, rows, normals, hit);
    const EyeFrame frame(view, width, height);
    const Surface surface{width, height, frame, normals, hit};
    const std::size_t first = surface.index(0, rows.begin);
    parallel_blocks(static_cast<std::size_t>(rows.end - rows.begin), kRowGrain,
                    [&](std::size_t begin, std::size_t end) {
        const int last = rows.begin + static_cast<int>(end);
        for (int y = rows.begin + static_cast<int>(begin); y < last; ++y)
            for (int x = 0; x < width; ++x) {
                const std::size_t i = surface.index(x, y);
                if (!hit[i]) continue;
                const Vec3f toward_eye = frame.toward_eye(frame.across(x), frame.upwards(y));
                pixel(i - first, surface.eye_normal(x, y, surface.raw_normal(i), toward_eye), toward_eye);
            }
    });
}

/// Some pixels of a row: their places, normals in camera axes and directions to the eye.
struct PixelLanes {
    int x, y, n;
    std::uint32_t hit;  ///< a bit each
    Vec3V normal, toward_eye;
};

/// The first n of some floats; zeros then.
FloatV load_some(const float* from, int n) {
    if (n == kLanes) return FloatV(from, stdx::element_aligned);
    alignas(64) std::array<float, kLanes> in{};
    std::copy_n(from, n, in.begin());
    return FloatV(in.data(), stdx::vector_aligned);
}

PixelLanes load_lanes(const Surface& surface, int x, int y) {
    const std::size_t i = surface.index(x, y);
    PixelLanes p;  // without a hit the vectors stay as they are: setting them first cost a quarter of the time
    p.x = x, p.y = y, p.n = std::min(kLanes, surface.width - x);
    p.hit = bits_of_bytes(&surface.hit[i], static_cast<std::size_t>(p.n));
    if (p.hit == 0) return p;
    const NormalPlanes& n = surface.normals;
    p.normal = unit_lanes(surface.frame.from_world(
        Vec3V{load_some(&n.x[i], p.n), load_some(&n.y[i], p.n), load_some(&n.z[i], p.n)}));
    p.toward_eye = surface.frame.toward_eye(surface.frame.across(x),
                                            2 / static_cast<float>(surface.frame.whole_width),
                                            surface.frame.upwards(y));
    return p;
}

/// Silhouettes are few: one by one.
void turn_to_eye(const Surface& surface, PixelLanes& p) {
    const auto away = static_cast<std::uint32_t>(lane_bits(p.normal.dot(p.toward_eye) < 0.0f));
    for (std::uint32_t bits = away & p.hit; bits != 0; bits &= bits - 1) {
        const int lane = std::countr_zero(bits);
        p.normal.set(lane, surface.eye_normal(p.x + lane, p.y, p.normal.at(lane), p.toward_eye.at(lane)));
    }
}

/// Blinn's highlight of the key light, fading in with n.l so that it cannot shine on the dark side.
FloatV highlight(const Lighting& l, const PixelLanes& p, const FloatV& facing_key) {
    const Vec3V half = unit_lanes({p.toward_eye.x + l.key.toward.x, p.toward_eye.y + l.key.toward.y,
                                   p.toward_eye.z + l.key.toward.z});
    const FloatV facing = clamp_lanes(4.0f * facing_key);
    return l.specular * facing * power_lanes(stdx::max(FloatV(0.0f), p.normal.dot(half)), l.shininess);
}

/// Light that the pixels send to the eye, linear; 0 without a hit.
Vec3V reflected(const Lighting& l, const PixelLanes& p) {
    const FloatV upward = 0.5f * (1.0f + p.normal.y), downward = 1.0f - upward;
    const FloatV at_key = p.normal.dot(l.key.toward);
    const FloatV key = stdx::max(FloatV(0.0f), at_key);
    const FloatV fill = stdx::max(FloatV(0.0f), p.normal.dot(l.fill.toward));
    const FloatV shine = highlight(l, p, at_key);
    const auto hit = lanes_of_bits(p.hit);
    const auto channel = [&](std::size_t c) {
        const FloatV diffuse = upward * l.sky[c] + downward * l.ground[c] + key * l.key.color[c] + fill * l.fill.color[c];
        return select<FloatV>(hit, l.albedo[c] * diffuse + l.key.color[c] * shine, FloatV(0.0f));
    };
    return {channel(0), channel(1), channel(2)};
}

void store_lanes(const Vec3V& color, const FloatV& alpha, int n, float* rgba) {
    if (n == kLanes) return store_interleaved(color.x, color.y, color.z, alpha, rgba);
    std::array<float, 4 * kLanes> some;
    store_interleaved(color.x, color.y, color.z, alpha, some.data());
    std::copy_n(some.begin(), 4 * n, rgba);
}

[[gnu::flatten]] void shade_lanes(const Surface& surface, const Lighting& lighting, int x, int y, float* rgba) {
    PixelLanes p = load_lanes(surface, x, y);
    if (p.hit == 0) {
        const FloatV zero(0.0f);  // stored as colours are: g++ 12 makes a slow string instruction of a fill
        return store_lanes({zero, zero, zero}, zero, p.n, rgba);
    }
    turn_to_eye(surface, p);
    store_lanes(reflected(lighting, p), select<FloatV>(lanes_of_bits(p.hit), FloatV(1.0f), FloatV(0.0f)), p.n, rgba);
}

}  // namespace

int shade_reach(int width, int height) { return std::max(2, std::max(width, height) / 200); }

Vec3f silhouette_normal(const Vec3f& normal, const Vec3f& toward_eye) {
    constexpr float kMirrored = 0.3f;
    const float away = -dot(normal, toward_eye);
    if (!(away > 0)) return normal;
    if (away >= kTurnedRound) return -normal;
    // Across the view: as it is for the mirror image, reversed for the normal turned round.
    const Vec3f across = normal + toward_eye * away;
    const float t = std::clamp((away - kMirrored) / (kTurnedRound - kMirrored), 0.0f, 1.0f);
    return normalized(across * (1 - 2 * t) + toward_eye * away);
}

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
    check_planes(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), height, rows, normals, hit);
    out.width = width, out.height = rows.end - rows.begin;
    out.rgba.resize(4 * out.n_pixels());
    const EyeFrame frame(view, width, height);
    const Surface surface{width, height, frame, normals, hit};
    parallel_blocks(static_cast<std::size_t>(out.height), kRowGrain, [&](std::size_t begin, std::size_t end) {
        for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y)
            for (int x = 0; x < width; x += kLanes)
                shade_lanes(surface, lighting, x, rows.begin + y, out.pixel(x, y));
    });
}

std::array<std::vector<float>, 3> turned_normals(int width, int height, const ShadeView& view, const NormalPlanes& normals,
                                                 std::span<const std::uint8_t> hit) {
    std::array<std::vector<float>, 3> out;
    for (auto& plane : out) plane.assign(hit.size(), 0.0f);
    const Vec3f right = to_float(view.right), up = to_float(view.up), back = to_float(view.back);
    for_hits(width, height, {0, height}, view, normals, hit, [&](std::size_t i, const Vec3f& n, const Vec3f&) {
        const Vec3f world = right * n.x + up * n.y + back * n.z;
        for (std::size_t axis = 0; axis < 3; ++axis) out[axis][i] = world[axis];
    });
    return out;
}

void light_picture(const ShadeView& view, const NormalPlanes& normals,
                   std::span<const std::uint8_t> hit, float floor, Picture& picture,
                   int first_row) {
    const Vec3f toward = Lighting{}.key.toward;
    const int height =
        static_cast<int>(hit.size() / static_cast<std::size_t>(std::max(1, picture.width)));
    for_hits(picture.width, height, {first_row, first_row + picture.height}, view, normals, hit,
             [&](std::size_t i, const Vec3f& n, const Vec3f&) {
                 const float wrapped = 0.5f * (1 + dot(n, toward));
                 const float light = floor + (1 - floor) * wrapped;
                 for (std::size_t c = 0; c < 3; ++c) picture.rgba[4 * i + c] *= light;
             });
}

void for_eye_rows(int width, int height, const RowRange& rows, const ShadeView& view,
                  const NormalPlanes& normals, std::span<const std::uint8_t> hit,
                  const std::function<void(const EyeRow&)>& visit) {
    const auto n = static_cast<std::size_t>(width);
    check_planes(n * static_cast<std::size_t>(height), height, rows, normals, hit);
    const EyeFrame frame(view, width, height);
    const Surface surface{width, height, frame, normals, hit};
    parallel_blocks(static_cast<std::size_t>(rows.end - rows.begin), kRowGrain,
                    [&](std::size_t begin, std::size_t end) {
                        std::vector<Vec3f> normal(n), toward_eye(n);
                        for (int y = rows.begin + static_cast<int>(begin);
                             y < rows.begin + static_cast<int>(end); ++y) {
                            for (int x = 0; x < width; ++x) {
                                const std::size_t i = surface.index(x, y);
                                if (!hit[i]) continue;
                                const auto k = static_cast<std::size_t>(x);
                                toward_eye[k] = frame.toward_eye(frame.across(x), frame.upwards(y));
                                normal[k] =
                                    surface.eye_normal(x, y, surface.raw_normal(i), toward_eye[k]);
                            }
                            visit({y, hit.subspan(surface.index(0, y), n), normal, toward_eye});
                        }
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
