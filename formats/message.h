#pragma once

#include <sstream>
#include <string>

namespace slim {

/// Joins printable things to one message; for errors, not for hot code.
template <class... Parts>
std::string message(const Parts&... parts) {
    std::ostringstream out;
    (out << ... << parts);
    return out.str();
}

}  // namespace slim
