#pragma once

#include <string>

namespace slim {

/// A number as people write it: so many digits, all before the point where there are more ("1005",
/// not "1e+03"), powers of ten only below 1e-4 and from 1e7 on.
std::string plain_number(double value, int digits);

/// "12.3 ms", "1.05 s".
std::string duration_text(double ms);

}  // namespace slim
