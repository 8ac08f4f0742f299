#include "raytrace/lines/crossings.h"

namespace slim {
namespace {

/// Entry point of a found edge into the picture.
Crossing place_crossing(const LineScene& scene, std::size_t a, std::size_t b, const EdgeHit& hit) {
    const auto width = static_cast<std::size_t>(scene.buffer.width);
    const bool down = b != a + 1;
    Crossing c;
    c.x = static_cast<float>(a % width) + 0.5f + (down ? 0.0f : hit.s);
    c.y = static_cast<float>(a / width + static_cast<std::size_t>(scene.rows.top)) + 0.5f +
          (down ? hit.s : 0.0f);
    c.weight = hit.weight, c.evidence = hit.evidence;
    c.edge = static_cast<std::uint32_t>(2 * (a % width) + (down ? 1 : 0));
    if (hit.surface == EdgeHit::Side::both) {
        c.pixel = static_cast<std::uint32_t>(hit.s < 0.5f ? a : b);
        c.point = scene.point(a) * (1 - hit.s) + scene.point(b) * hit.s;
        return c;
    }
    const std::size_t own = hit.surface == EdgeHit::Side::a ? a : b;
    c.pixel = static_cast<std::uint32_t>(own);
    const float share = own == a ? hit.s : hit.s - 1;
    c.point = scene.moved(own, down ? 0 : share, down ? share : 0);
    return c;
}

}  // namespace

void RowCrossings::add(std::size_t a, std::size_t b, const std::optional<EdgeHit>& hit) {
    if (hit) crossings_.push_back(place_crossing(scene_, a, b, *hit));
}

CrossingField joined_rows(const LineScene& scene, std::vector<RowCrossings> bands) {
    const auto n_rows = static_cast<int>(scene.end_row() - scene.first_row());
    CrossingField field{scene.buffer.width, n_rows, {}, {0}};
    std::size_t n = 0;
    for (const RowCrossings& band : bands) n += band.crossings_.size();
    field.crossings.reserve(n);
    for (RowCrossings& band : bands) {
        for (std::size_t row = 1; row < band.row_start_.size(); ++row)
            field.row_start.push_back(field.crossings.size() + band.row_start_[row]);
        field.crossings.insert(field.crossings.end(), band.crossings_.begin(),
                               band.crossings_.end());
        band.crossings_ = {};
    }
    return field;
}

}  // namespace slim
