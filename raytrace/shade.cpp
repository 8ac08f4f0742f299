#include "raytrace/shade.h"

#include "slim/base/check.h"
#include "slim/base/parallel.h"

#include <algorithm>
#include <cmath>

namespace slim {
namespace {

constexpr std::size_t kRowGrain = 8;

Vec3f multiply(const Vec3f& a, const Vec3f& b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }

/// The camera's axes in floats, and the direction from a pixel's surface to the eye in those axes.
struct EyeFrame {
    Vec3f right, up, back;
    float half_width, half_height;
    bool orthographic;

    explicit EyeFrame(const ShadeView& v)
        : right(to_float(v.right)), up(to_float(v.up)), back(to_float(v.back)),
          half_width(static_cast<float>(v.half_width)),
          half_height(static_cast<float>(v.half_height)), orthographic(v.orthographic) {}

    Vec3f from_world(const Vec3f& d) const { return {dot(right, d), dot(up, d), dot(back, d)}; }

    /// s, t in [-1, 1] over the picture, t upwards.
    Vec3f toward_eye(float s, float t) const {
        if (orthographic) return {0, 0, 1};
        return normalized(Vec3f{-s * half_width, -t * half_height, 1});
    }
};

float screen_coordinate(int pixel, int n) {
    return (static_cast<float>(pixel) + 0.5f) * 2 / static_cast<float>(n) - 1;
}

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
        return normalized(frame.from_world({normals.x[i], normals.y[i], normals.z[i]}));
    }

    bool faces(int x, int y, const Vec3f& toward_eye) const {
        if (x < 0 || y < 0 || x >= width || y >= height) return false;
        const std::size_t i = index(x, y);
        return hit[i] && dot(raw_normal(i), toward_eye) > 0;
    }

    /// Whether a pixel in one of eight directions faces the eye; the nearest are asked first.
    bool is_near_front(int x, int y, const Vec3f& toward_eye) const {
        const int reach = std::max(2, std::max(width, height) / 200);
        for (int r = 1; r <= reach; ++r)
            for (int dy = -r; dy <= r; dy += r)
                for (int dx = -r; dx <= r; dx += r)
                    if (faces(x + dx, y + dy, toward_eye)) return true;
        return false;
    }

    /// The normal of one pixel, turned to the eye; zero where the renderer had none.
    Vec3f eye_normal(int x, int y, const Vec3f& toward_eye) const {
        const Vec3f n = raw_normal(index(x, y));
        const float away = -dot(n, toward_eye);
        if (!(away > 0)) return n;
        if (away >= kTurnedRound || !is_near_front(x, y, toward_eye)) return -n;
        return silhouette_normal(n, toward_eye);
    }
};

Vec3f diffuse(const Light& light, const Vec3f& n) {
    return light.color * std::max(0.0f, dot(n, light.toward));
}

/// Blinn's highlight of the key light, fading in with n.l so that it cannot shine on the dark side.
Vec3f highlight(const Lighting& l, const Vec3f& n, const Vec3f& toward_eye) {
    const float facing = std::clamp(4 * dot(n, l.key.toward), 0.0f, 1.0f);
    const Vec3f half = normalized(l.key.toward + toward_eye);
    const float base = std::max(0.0f, dot(n, half));
    return l.key.color * (l.specular * facing * std::pow(base, l.shininess));
}

Vec3f reflected(const Lighting& l, const Vec3f& n, const Vec3f& toward_eye) {
    const float upward = 0.5f * (1 + n.y);
    const Vec3f ambient = l.sky * upward + l.ground * (1 - upward);
    return multiply(l.albedo, ambient + diffuse(l.key, n) + diffuse(l.fill, n)) +
           highlight(l, n, toward_eye);
}

/// Calls pixel(i, n, toward_eye) at every hit of some rows, in parallel; i counts from their first.
template <class Body>
void for_hits(int width, int height, const RowRange& rows, const ShadeView& view,
              const NormalPlanes& normals, std::span<const std::uint8_t> hit, const Body& pixel) {
    const auto n_pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    SLIM_CHECK(hit.size(), ==, n_pixels);
    SLIM_CHECK(std::min({normals.x.size(), normals.y.size(), normals.z.size()}), ==, n_pixels);
    SLIM_CHECK(rows.begin, >=, 0);
    SLIM_CHECK(rows.end, <=, height);
    const EyeFrame frame(view);
    const Surface surface{width, height, frame, normals, hit};
    const std::size_t first = surface.index(0, rows.begin);
    parallel_blocks(static_cast<std::size_t>(rows.end - rows.begin), kRowGrain,
                    [&](std::size_t begin, std::size_t end) {
        const int last = rows.begin + static_cast<int>(end);
        for (int y = rows.begin + static_cast<int>(begin); y < last; ++y)
            for (int x = 0; x < width; ++x) {
                const std::size_t i = surface.index(x, y);
                if (!hit[i]) continue;
                const Vec3f toward_eye = frame.toward_eye(screen_coordinate(x, width),
                                                          -screen_coordinate(y, height));
                pixel(i - first, surface.eye_normal(x, y, toward_eye), toward_eye);
            }
    });
}

}  // namespace

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
    Picture out(width, rows.end - rows.begin);
    for_hits(width, height, rows, view, normals, hit,
             [&](std::size_t i, const Vec3f& n, const Vec3f& toward_eye) {
                 const Vec3f c = reflected(lighting, n, toward_eye);
                 float* p = &out.rgba[4 * i];
                 p[0] = c.x, p[1] = c.y, p[2] = c.z, p[3] = 1;
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

void composite_over(const Background& background, Picture& picture) {
    for (int y = 0; y < picture.height; ++y) {
        const float t = (static_cast<float>(y) + 0.5f) / static_cast<float>(picture.height);
        const Vec3f c = background.top * (1 - t) + background.bottom * t;
        for (int x = 0; x < picture.width; ++x) {
            float* p = picture.pixel(x, y);
            const float through = background.alpha * (1 - p[3]);
            p[0] += through * c.x, p[1] += through * c.y, p[2] += through * c.z, p[3] += through;
        }
    }
}

}  // namespace slim
