#include "raytrace/lines/crossings.h"
#include "raytrace/lines/sheet_blur.h"

#include <cmath>
#include <vector>

namespace slim {

CrossingField parabolic_crossings(const LineScene& s, const Sheets& sheets) {
    const GBuffer& g = s.buffer;
    const auto curved = [&g](std::size_t i) {
        return std::fmax(std::fabs(g.k1[i]), std::fabs(g.k2[i]));
    };
    // seams between surfels make it jagged
    const std::vector<float> gauss = blurred(sheets, g.gauss);
    return find_on_sheets(s, sheets, [&](std::size_t a, std::size_t b) -> std::optional<EdgeHit> {
        const float ka = gauss[a], kb = gauss[b];
        if ((ka > 0) == (kb > 0) || ka == kb) return std::nullopt;
        const float at = ka / (ka - kb);
        return EdgeHit{at, curved(a) * (1 - at) + curved(b) * at};
    });
}

}  // namespace slim
