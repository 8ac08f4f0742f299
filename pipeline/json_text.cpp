#include "pipeline/json_text.h"

#include <nlohmann/json.hpp>

#include <istream>

namespace slim {

using nlohmann::json;

json json_from(std::istream& in) { return json::parse(in); }

json json_or_discarded(std::istream& in) { return json::parse(in, nullptr, false); }

json json_or_discarded(const std::string& text) { return json::parse(text, nullptr, false); }

std::string text_of(const json& value, int indent) {
    return value.dump(indent, ' ', false, json::error_handler_t::replace);
}

}  // namespace slim
