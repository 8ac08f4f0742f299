#pragma once

#include <string>

namespace slim {

/// ".png" of "out/x.PNG", "" of a name without one: what a name says of its format does not depend
/// on case.
std::string lower_extension(const std::string& path);

}  // namespace slim
