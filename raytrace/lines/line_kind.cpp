#include "raytrace/lines/line_kind.h"

namespace slim {
namespace {

Channels channels_of_kind(LineKind kind, int degree) {
    constexpr Channels kPlace = kPositionChannel | kNormalChannel;
    constexpr Channels kShape = kK1Channel | kK2Channel | kDirectionChannel;
    switch (kind) {
        case LineKind::contour:
            return kPlace | kFitErrorChannel;
        case LineKind::reflection:
        case LineKind::convex_crease:
        case LineKind::concave_crease:
            return kPlace;
        case LineKind::parabolic:
            return kPlace | kGaussChannel | kK1Channel | kK2Channel | kFitErrorChannel;
        case LineKind::suggestive:
            return kPlace | kShape | (degree >= 3 ? kThirdOrderChannel : Channels{0});
        case LineKind::ridge:
        case LineKind::valley:
            return kPlace | kShape | kThirdOrderChannel;
    }
    return 0;
}

}  // namespace

std::string_view line_name(LineKind kind) {
    constexpr std::array<std::string_view, kLineKinds> kNames{
        "contour",   "suggestive", "ridge",         "valley",
        "parabolic", "reflection", "convex_crease", "concave_crease"};
    return kNames[static_cast<std::size_t>(kind)];
}

int line_degree(LineKind kind) {
    if (kind == LineKind::ridge || kind == LineKind::valley) return 3;
    return kind == LineKind::suggestive || kind == LineKind::parabolic ? 2 : 1;
}

Channels line_channels(std::span<const LineKind> kinds, int degree) {
    Channels channels = 0;
    for (const LineKind kind : kinds) channels |= channels_of_kind(kind, degree);
    return channels;
}

}  // namespace slim
