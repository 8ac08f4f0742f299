#include "raytrace/lines/extract.h"

#include "raytrace/lines/line_search.h"

namespace slim {

std::vector<FeatureLine> extract_lines(const LineScene& scene, std::span<const LineKind> kinds) {
    LineSearch search(kinds);
    search.add(scene);
    return search.finish();
}

}  // namespace slim
