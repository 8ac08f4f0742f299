#pragma once

#include "raytrace/frame.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

namespace slim {

/// The feature lines that can be drawn (NUMERICS 5.4).
enum class LineKind : std::uint8_t {
    contour,     ///< occluding contours: depth jumps, the silhouette, sign changes of N.v
    suggestive,  ///< zeros of the radial curvature that would be contours from a view nearby
    ridge,       ///< crest lines where k1 is greatest along t1
    valley,      ///< ravines: crest lines where k2 is least along t2
    parabolic,   ///< zeros of the Gaussian curvature
    reflection,  ///< edges of stripes of light that the surface reflects
    convex_crease,   ///< sharp edges: where two sheets of the model's surfels meet
    concave_crease,  ///< the same where the surface is hollow
};
inline constexpr std::size_t kLineKinds = 8;
inline constexpr std::array<LineKind, kLineKinds> kAllLineKinds{
    LineKind::contour,   LineKind::suggestive, LineKind::ridge,         LineKind::valley,
    LineKind::parabolic, LineKind::reflection, LineKind::convex_crease, LineKind::concave_crease};

/// Sharp edges, which are the model's own and not found in the picture.
constexpr bool is_crease(LineKind kind) {
    return kind == LineKind::convex_crease || kind == LineKind::concave_crease;
}

/// "contour", "suggestive", "ridge", "valley", "parabolic", "reflection", "convex_crease",
/// "concave_crease".
std::string_view line_name(LineKind kind);

/// Least degree of a model whose derivatives tell these lines: 3 for crest lines, 2 where curvature
/// is needed, 1 otherwise.
int line_degree(LineKind kind);

/// What a renderer must deliver for these lines from a model of that degree, and no more.
Channels line_channels(std::span<const LineKind> kinds, int degree);

}  // namespace slim
