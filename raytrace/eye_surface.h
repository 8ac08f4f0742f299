#pragma once

#include "raytrace/lanes_of_vec.h"
#include "raytrace/shade.h"
#include "slim/base/simd.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace slim {

// What shadings share: a picture's surface in camera axes, its normals turned to the eye.

inline float screen_coordinate(int pixel, int n) {
    return (static_cast<float>(pixel) + 0.5f) * 2 / static_cast<float>(n) - 1;
}

/// The camera's axes in floats, and the direction from a pixel's surface to the eye in those axes.
struct EyeFrame {
    Vec3f right, up, back;
    float half_width, half_height;
    bool orthographic;
    int first_x, first_y, whole_width, whole_height;
    const CoarsePlanes* around;

    /// Even over a disc of shade_reach pixels.
    static constexpr std::size_t kPlaces = 32;
    std::array<std::array<int, 2>, kPlaces> places;

    EyeFrame(const ShadeView& v, int width, int height);

    Vec3f from_world(const Vec3f& d) const { return {dot(right, d), dot(up, d), dot(back, d)}; }
    Vec3f to_world(const Vec3f& d) const { return right * d.x + up * d.y + back * d.z; }
    LanesOfVec from_world(const LanesOfVec& d) const {
        return {d.dot(right), d.dot(up), d.dot(back)};
    }

    /// Column x and row y of the planes in [-1, 1] over the whole picture, rightwards and upwards.
    float across(int x) const { return screen_coordinate(first_x + x, whole_width); }
    float upwards(int y) const { return -screen_coordinate(first_y + y, whole_height); }

    /// s, t in [-1, 1] over the picture, t upwards.
    Vec3f toward_eye(float s, float t) const {
        if (orthographic) return {0, 0, 1};
        return normalized(Vec3f{-s * half_width, -t * half_height, 1});
    }
    /// The same at s, s + step, ...
    LanesOfVec toward_eye(float s, float step, float t) const {
        const FloatV lane([](auto k) { return static_cast<float>(k); });
        return toward_eye(FloatV(s), lane, step, FloatV(t));
    }
    /// The same at s + n step.
    LanesOfVec toward_eye(const FloatV& s, const FloatV& n, float step, const FloatV& t) const {
        if (orthographic) return {FloatV(0.0f), FloatV(0.0f), FloatV(1.0f)};
        return LanesOfVec{-half_width * (s + n * step), -t * half_height, FloatV(1.0f)}.unit();
    }
};

/// The planes of a whole picture in camera axes.
struct EyeSurface {
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

    /// The normal that the planes, or those around, have at a place; null without a hit or outside.
    std::optional<Vec3f> normal_near(int x, int y) const;

    /// Of the surface about a pixel whose normal n faces away, within shade_reach, the share that
    /// faces the eye with a normal less than 60 degrees from n: near one half where a front
    /// overshoots its edge, 0 on the back of a sheet.
    float share_of_front(int x, int y, const Vec3f& n, const Vec3f& toward_eye) const;

    /// The normal n of one pixel, turned to the eye; zero where the renderer had none.
    Vec3f eye_normal(int x, int y, const Vec3f& n, const Vec3f& toward_eye) const;
};

/// That the planes are those of a picture of these pixels, and the rows are in it.
void check_planes(std::size_t n_pixels, int height, const RowRange& rows,
                  const NormalPlanes& normals, std::span<const std::uint8_t> hit);

/// Rows that a thread takes at a time.
inline constexpr std::size_t kShadedRows = 8;

}  // namespace slim
