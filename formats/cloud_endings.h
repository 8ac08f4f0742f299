#pragma once

#include <string>
#include <string_view>

namespace slim {

/// Whether a text of coordinates may be named so: ".xyz" and its like (lower_extension).
bool is_text_ending(std::string_view ending);

/// Whether a cloud that is read may be named so: a PLY or such a text; not packed.
bool is_cloud_ending(std::string_view ending);

/// The endings of texts, for messages: ".xyz, .txt, ... or .csv" with ", " between them and " or "
/// before the last.
std::string text_endings(std::string_view between, std::string_view before_last);

}  // namespace slim
