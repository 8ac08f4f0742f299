#include "raytrace/eye_surface.h"

#include "slim/base/check.h"
#include "slim/base/parallel.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace slim {
namespace {

constexpr float kTurnedRound = 0.5f;  ///< from -n . e on no silhouette
constexpr float kSameSurface = 0.5f;  ///< cosine between normals of one surface that turns away
/// Shares of a neighbourhood that face the eye: up to the first a pixel is of a sheet's back, from
/// the second on an overshoot.
constexpr float kBack = 0.1f, kOvershoot = 0.3f;
constexpr std::size_t kPlaces = EyeFrame::kPlaces;

/// Even over the unit disc: a spiral with the golden angle, which has no direction of its own.
std::array<std::array<float, 2>, kPlaces> places_in_disc() {
    constexpr double kGoldenAngle = 2.399963229728653;
    std::array<std::array<float, 2>, kPlaces> out{};
    for (std::size_t i = 0; i < kPlaces; ++i) {
        const double r = std::sqrt((static_cast<double>(i) + 0.5) / kPlaces),
                     a = static_cast<double>(i) * kGoldenAngle;
        out[i] = {static_cast<float>(r * std::cos(a)), static_cast<float>(r * std::sin(a))};
    }
    return out;
}

/// Calls pixel(i, n, toward_eye) at every hit of some rows, in parallel; i counts from their first.
template <class Body>
void for_hits(int width, int height, const RowRange& rows, const ShadeView& view,
              const NormalPlanes& normals, std::span<const std::uint8_t> hit, const Body& pixel) {
    const auto n_pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    check_planes(n_pixels, height, rows, normals, hit);
    const EyeFrame frame(view, width, height);
    const EyeSurface surface{width, height, frame, normals, hit};
    const std::size_t first = surface.index(0, rows.begin);
    parallel_blocks(static_cast<std::size_t>(rows.end - rows.begin), kShadedRows,
                    [&](std::size_t begin, std::size_t end) {
        const int last = rows.begin + static_cast<int>(end);
        for (int y = rows.begin + static_cast<int>(begin); y < last; ++y)
            for (int x = 0; x < width; ++x) {
                const std::size_t i = surface.index(x, y);
                if (!hit[i]) continue;
                const Vec3f toward_eye = frame.toward_eye(frame.across(x), frame.upwards(y));
                pixel(i - first, surface.eye_normal(x, y, surface.raw_normal(i), toward_eye),
                      toward_eye);
            }
    });
}

}  // namespace

std::optional<Vec3f> EyeSurface::normal_near(int x, int y) const {
    const auto read = [](const NormalPlanes& from, std::span<const std::uint8_t> covered,
                         std::size_t i) -> std::optional<Vec3f> {
        if (!covered[i]) return std::nullopt;
        return Vec3f{from.x[i], from.y[i], from.z[i]};
    };
    if (!frame.around) {
        if (x < 0 || y < 0 || x >= width || y >= height) return std::nullopt;
        return read(normals, hit, index(x, y));
    }
    const CoarsePlanes& c = *frame.around;
    const int left = frame.first_x + x - 2 * c.first_x, top = frame.first_y + y - 2 * c.first_y;
    if (left < 0 || top < 0 || left >= 2 * c.width || top >= 2 * c.height) return std::nullopt;
    return read(c.normals, c.hit,
                static_cast<std::size_t>(top / 2) * static_cast<std::size_t>(c.width) +
                    static_cast<std::size_t>(left / 2));
}

EyeFrame::EyeFrame(const ShadeView& v, int width, int height)
    : right(to_float(v.right)),
      up(to_float(v.up)),
      back(to_float(v.back)),
      half_width(static_cast<float>(v.half_width)),
      half_height(static_cast<float>(v.half_height)),
      orthographic(v.orthographic),
      first_x(v.first_x),
      first_y(v.first_y),
      whole_width(v.whole_width > 0 ? v.whole_width : width),
      whole_height(v.whole_height > 0 ? v.whole_height : height),
      around(v.around) {
    static const std::array<std::array<float, 2>, kPlaces> disc = places_in_disc();
    const auto reach = static_cast<float>(shade_reach(whole_width, whole_height));
    const auto nearest = [](float offset) { return static_cast<int>(std::floor(offset + 0.5f)); };
    for (std::size_t k = 0; k < kPlaces; ++k)
        places[k] = {nearest(reach * disc[k][0]), nearest(reach * disc[k][1])};
}

float EyeSurface::share_of_front(int x, int y, const Vec3f& n, const Vec3f& toward_eye) const {
    // In the axes of the planes: two products a place instead of a normal turned and made unit.
    const Vec3f eye = frame.to_world(toward_eye), same = frame.to_world(n);
    int hits = 0, front = 0;
    for (const auto& [dx, dy] : frame.places) {
        const std::optional<Vec3f> there = normal_near(x + dx, y + dy);
        if (!there) continue;
        ++hits, front += dot(*there, eye) > 0 && dot(*there, same) > kSameSurface * length(*there);
    }
    return hits > 0 ? static_cast<float>(front) / static_cast<float>(hits) : 0;
}

Vec3f EyeSurface::eye_normal(int x, int y, const Vec3f& n, const Vec3f& toward_eye) const {
    const float away = -dot(n, toward_eye);
    if (!(away > 0)) return n;
    if (away >= kTurnedRound) return -n;
    const float t = std::clamp((share_of_front(x, y, n, toward_eye) - kBack) / (kOvershoot - kBack),
                               0.0f, 1.0f);
    if (t == 0) return -n;
    return normalized(silhouette_normal(n, toward_eye) * t - n * (1 - t));
}

void check_planes(std::size_t n_pixels, int height, const RowRange& rows,
                  const NormalPlanes& normals, std::span<const std::uint8_t> hit) {
    SLIM_CHECK(hit.size(), ==, n_pixels);
    SLIM_CHECK(std::min({normals.x.size(), normals.y.size(), normals.z.size()}), ==, n_pixels);
    SLIM_CHECK(rows.begin, >=, 0);
    SLIM_CHECK(rows.end, <=, height);
}

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

std::array<std::vector<float>, 3> turned_normals(int width, int height, const ShadeView& view,
                                                 const NormalPlanes& normals,
                                                 std::span<const std::uint8_t> hit) {
    std::array<std::vector<float>, 3> out;
    for (auto& plane : out) plane.assign(hit.size(), 0.0f);
    const Vec3f right = to_float(view.right), up = to_float(view.up), back = to_float(view.back);
    for_hits(width, height, {0, height}, view, normals, hit,
             [&](std::size_t i, const Vec3f& n, const Vec3f&) {
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
    const EyeSurface surface{width, height, frame, normals, hit};
    parallel_blocks(static_cast<std::size_t>(rows.end - rows.begin), kShadedRows,
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

}  // namespace slim
