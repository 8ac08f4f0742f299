#pragma once

#include "pipeline/report/report_file.h"

#include <nlohmann/json.hpp>

#include <cstdint>
#include <string>
#include <vector>

namespace slim {

/// A cloud made by formulas, for the inputs that no scanner gives: scaled, moved, doubled, thinned,
/// of known shape.
///
/// from      clouds one behind the other; their truth goes along if all have it. Without:
///           n_points points at 0.
/// formulas  for each point x y z nx ny nz k1 k2 (those not named stay) and keep (0 drops it), of
///           these names: the point's own, i (its number), n (of all, as far as is known), file (0,
///           1, ... in from), r1..r4 (uniform in [0, 1)) and g1 g2 g3 (normal), keyed by the seed
///           and i; and the row's
/// output    PLY: double coordinates (floats if `single`), float normals if there are any, truth
///           beside it if there is any. `.xyz`: text
/// returns   points, and the diagonal of their box
/// throws    as open_cloud and AtomicFile
nlohmann::json make_cloud(const std::vector<std::string>& from, std::uint64_t n_points,
                          const std::vector<std::pair<std::string, Expression>>& formulas,
                          const Expression::Lookup& row, std::uint64_t seed, bool single,
                          const std::string& output);

}  // namespace slim
