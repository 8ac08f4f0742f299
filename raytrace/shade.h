#pragma once

#include "raytrace/picture.h"
#include "slim/base/vec.h"

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace slim {

/// One plane per coordinate; pixels without a hit are ignored.
struct NormalPlanes {
    std::span<const float> x, y, z;
};

/// The surface of a part of a picture of half the size, from pixel (first_x, first_y) on.
struct CoarsePlanes {
    std::span<const std::uint8_t> hit;
    NormalPlanes normals;
    int first_x, first_y, width, height;
};

/// What shading knows of a view: the camera's axes (unit, world) and half the picture's extent on
/// the plane at distance 1 in front of the eye (perspective; y over x by the aspect).
struct ShadeView {
    Vec3d right{1, 0, 0}, up{0, 1, 0}, back{0, 0, 1};
    double half_width = 1, half_height = 1;
    bool orthographic = false;
    /// Where the planes that are shaded begin in a larger picture, and its size; 0: they are the
    /// whole.
    int first_x = 0, first_y = 0, whole_width = 0, whole_height = 0;
    /// What lies about a pixel where the planes hold only some of the picture's (SampleMask); null:
    /// what they hold.
    const CoarsePlanes* around = nullptr;
};

/// A directional light that stands still relative to the camera; `toward` is the direction to the
/// light in camera axes (right, up, back), unit length.
struct Light {
    Vec3f toward;
    Vec3f color;  ///< linear Rec.709, radiance at normal incidence times 1/pi folded in
};

/// Blinn-Phong (Blinn 1977) with two lights and a hemisphere of ambient light. Colours in linear
/// Rec.709. The defaults are grey clay under a studio key from the upper left.
struct Lighting {
    Light key{{-0.5145f, 0.6175f, 0.5949f}, {0.86f, 0.83f, 0.78f}};
    Light fill{{0.8452f, -0.0845f, 0.5278f}, {0.13f, 0.15f, 0.19f}};
    Vec3f sky{0.235f, 0.250f, 0.275f};     ///< ambient on a normal that points up
    Vec3f ground{0.085f, 0.077f, 0.070f};  ///< ambient on a normal that points down
    Vec3f albedo{0.690f, 0.632f, 0.572f};
    float specular = 0.11f;                ///< key light only
    int shininess = 36;                    ///< exponent, at least 1; whole: a
                                           ///< power is a few products
};

/// Rows [begin, end) of a picture.
struct RowRange {
    int begin = 0, end = 0;
};

/// The normal of a silhouette whose polynomial overshoots the edge, so that it just turns away from
/// the eye: turned round it would be a dark rim, so it is mirrored at the plane across the view
/// instead, which is continuous at the edge. From n . e = -0.3 to -0.5 the mirror image becomes the
/// normal turned round, which it is beyond; one that faces the eye is left as it is.
///
/// normal, toward_eye  unit, any frame they share
/// returns             unit, n . e >= 0
Vec3f silhouette_normal(const Vec3f& normal, const Vec3f& toward_eye);

/// How far, in pixels, the shading of a pixel of a width x height picture looks at others (see
/// shade).
int shade_reach(int width, int height);

/// Shades every hit pixel over transparent black. A normal that faces away is turned round, so both
/// sides of a sheet look alike; but where much of the surface within 1/200 of the picture's longer
/// side (at least 2 pixels) faces the eye with much the same normal, it is taken for an overshoot
/// of that: silhouette_normal.
///
/// normals, hit  width * height each, row-major from the top left;
///               hit != 0 where there is a surface
/// returns       premultiplied linear Rec.709, alpha 1 at hits and 0 elsewhere
/// cost          O(pixels), parallel over rows; a pure function of its arguments
Picture shade(int width, int height, const ShadeView& view, const NormalPlanes& normals,
              std::span<const std::uint8_t> hit, const Lighting& lighting = {});

/// The same for some rows only; the planes are those of the whole picture.
Picture shade_rows(int width, int height, const ShadeView& view, const NormalPlanes& normals,
                   std::span<const std::uint8_t> hit, const RowRange& rows,
                   const Lighting& lighting = {});

/// The same into a picture that keeps its memory: shading a frame again costs no new pages.
void shade_rows(int width, int height, const ShadeView& view, const NormalPlanes& normals,
                std::span<const std::uint8_t> hit, const RowRange& rows, const Lighting& lighting,
                Picture& out);

/// The normals of a whole picture as shading takes them, turned to the eye: unit, axes as given;
/// 0 without a hit.
std::array<std::vector<float>, 3> turned_normals(int width, int height, const ShadeView& view,
                                                 const NormalPlanes& normals,
                                                 std::span<const std::uint8_t> hit);

/// Multiplies a painted picture by a soft diffuse light (1 facing the light, `floor` facing away),
/// for curvature maps that are asked to show form as well. `picture` holds the rows from
/// `first_row` on of the whole picture that the planes belong to.
void light_picture(const ShadeView& view, const NormalPlanes& normals,
                   std::span<const std::uint8_t> hit, float floor, Picture& picture,
                   int first_row = 0);

/// The surface along a row of pixels: unit vectors in camera axes, normals turned to the eye as
/// shade() turns them.
struct EyeRow {
    int y = 0;  ///< of the planes
    std::span<const std::uint8_t> hit;
    std::span<const Vec3f> normal, toward_eye;  ///< at hits only
};

/// Calls visit(row) for some rows of the planes, in parallel: for shadings of one's own.
void for_eye_rows(int width, int height, const RowRange& rows, const ShadeView& view,
                  const NormalPlanes& normals, std::span<const std::uint8_t> hit,
                  const std::function<void(const EyeRow&)>& visit);

/// Vertical gradient behind a picture, linear Rec.709; alpha 0 leaves the picture as it is.
struct Background {
    Vec3f top{1, 1, 1}, bottom{1, 1, 1};
    float alpha = 1;
};

/// picture OVER background; the picture may be the rows from first_row on of one of whole_height
/// rows (0: all).
void composite_over(const Background& background, Picture& picture, int first_row = 0,
                    int whole_height = 0);

}  // namespace slim
