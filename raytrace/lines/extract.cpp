#include "raytrace/lines/extract.h"

#include "raytrace/lines/crossings.h"
#include "raytrace/lines/link.h"
#include "raytrace/lines/select.h"
#include "slim/base/check.h"

#include <optional>

namespace slim {
namespace {

constexpr int kSmoothingPasses = 8;

/// What kinds of lines of one scene share.
class Crossings {
public:
    explicit Crossings(const LineScene& scene) : scene_(scene) {}

    CrossingField of(LineKind kind) {
        switch (kind) {
            case LineKind::contour:
                return contour_crossings(scene_);
            case LineKind::suggestive:
                return suggestive_crossings(scene_, blur());
            case LineKind::ridge:
                return crest_crossings(scene_, blur(), true);
            case LineKind::valley:
                return crest_crossings(scene_, blur(), false);
            case LineKind::parabolic:
                return parabolic_crossings(scene_, blur());
            case LineKind::reflection:
                break;
        }
        return reflection_crossings(scene_);
    }

private:
    const SheetBlur& blur() {
        if (!blur_) blur_.emplace(scene_);
        return *blur_;
    }

    const LineScene& scene_;
    std::optional<SheetBlur> blur_;
};

}  // namespace

std::vector<FeatureLine> extract_lines(const LineScene& scene, std::span<const LineKind> kinds) {
    SLIM_CHECK(scene.buffer.has(line_channels(kinds, scene.degree)), ==, true);
    std::vector<FeatureLine> out;
    Crossings crossings(scene);
    for (const LineKind kind : kinds) {
        std::vector<FeatureLine> lines =
            select_lines(link_crossings(scene, crossings.of(kind), kind),
                         line_rules(kind, scene.buffer.width, scene.buffer.height));
        for (FeatureLine& line : lines) {
            smooth_line(line, kSmoothingPasses);
            measure_line(line);
            out.push_back(std::move(line));
        }
    }
    return out;
}

}  // namespace slim
