#pragma once

#include <sstream>
#include <stdexcept>

namespace slim {

/// A broken promise of our own code (exit 1), never of the input.
struct InternalError : std::logic_error {
    using std::logic_error::logic_error;
};

template <class A, class B>
[[noreturn]] void check_failed(const char* file, int line, const char* text, const A& a,
                               const B& b) {
    std::ostringstream message;
    message << file << ':' << line << ": SLIM_CHECK(" << text << ") failed with " << a << " and "
            << b;
    throw InternalError(message.str());
}

}  // namespace slim

/// Always on; prints both values. Usage: SLIM_CHECK(n, ==, points.size()).
#define SLIM_CHECK(a, op, b)                                                                \
    do {                                                                                    \
        const auto& slim_a = (a);                                                           \
        const auto& slim_b = (b);                                                           \
        if (!(slim_a op slim_b))                                                            \
            ::slim::check_failed(__FILE__, __LINE__, #a " " #op " " #b, slim_a, slim_b);     \
    } while (false)
