#include "pipeline/plain_number.h"

#include <fmt/format.h>

#include <cmath>

namespace slim {

std::string plain_number(double value, int digits) {
    const std::string text = fmt::format("{:.{}g}", value, digits);
    if (text.find("e+") == std::string::npos || !(std::abs(value) < 1e7)) return text;
    return fmt::format("{:.0f}", value);
}

std::string duration_text(double ms) {
    return ms < 999.5 ? plain_number(ms, 3) + " ms" : plain_number(ms / 1000, 3) + " s";
}

}  // namespace slim
