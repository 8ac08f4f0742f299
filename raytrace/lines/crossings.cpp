#include "raytrace/lines/crossings.h"

namespace slim {

Crossing place_crossing(const LineScene& scene, std::size_t a, std::size_t b, const EdgeHit& hit) {
    const auto width = static_cast<std::size_t>(scene.buffer.width);
    const bool down = b != a + 1;
    Crossing c;
    c.x = static_cast<float>(a % width) + 0.5f + (down ? 0.0f : hit.s);
    c.y = static_cast<float>(a / width) + 0.5f + (down ? hit.s : 0.0f);
    c.weight = hit.weight, c.evidence = hit.evidence;
    if (hit.surface == EdgeHit::Side::both) {
        c.pixel = static_cast<std::uint32_t>(hit.s < 0.5f ? a : b);
        c.point = scene.point(a) * (1 - hit.s) + scene.point(b) * hit.s;
        return c;
    }
    const std::size_t own = hit.surface == EdgeHit::Side::a ? a : b;
    c.pixel = static_cast<std::uint32_t>(own);
    c.point = to_float(scene.view.point_at(c.x, c.y, scene.depth(own)));
    return c;
}

}  // namespace slim
