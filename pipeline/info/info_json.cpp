#include "pipeline/info/info_json.h"

#include "pipeline/json_text.h"

namespace slim {

using nlohmann::json;

json vector_json(const Vec3d& v) { return {v.x, v.y, v.z}; }

json bounds_json(const Bbox& box, const Vec3d& origin) {
    if (box.empty()) return nullptr;
    return {{"min", vector_json(box.lo + origin)},
            {"max", vector_json(box.hi + origin)},
            {"diagonal", box.diagonal()}};
}

json parsed(const std::string& text) {
    const json value = json_or_discarded(text);
    return value.is_discarded() ? json(text) : value;
}

}  // namespace slim
