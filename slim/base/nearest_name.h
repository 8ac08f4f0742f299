#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace slim {

/// "did you mean 'degree'?" of the nearest known name, "" where none is near: up to two typos (of
/// a long word, in a third of its letters), but not in every letter. Case is no typo.
std::string did_you_mean(std::string_view wrong, const std::vector<std::string>& known);

/// The same in a sentence: " (did you mean 'degree'?)", or "".
std::string suggestion(std::string_view wrong, const std::vector<std::string>& known);

}  // namespace slim
