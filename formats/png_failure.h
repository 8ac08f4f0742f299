#pragma once

#include <csetjmp>
#include <exception>
#include <png.h>
#include <string>

namespace slim {

/// What libpng, which is C, is to throw once it has returned: its own words, or what our stream
/// threw.
struct PngFailure {
    std::jmp_buf out;
    std::string words;
    std::exception_ptr thrown;

    [[noreturn]] static void leave(png_structp png, png_const_charp words) {
        auto& failure = *static_cast<PngFailure*>(png_get_error_ptr(png));
        failure.words = words;
        std::longjmp(failure.out, 1);
    }
    static void ignore(png_structp, png_const_charp) {}
};

/// Calls of libpng only: no object of the body may need its destructor. Returns false after a
/// failure.
template <class Body>
bool without_failure(PngFailure& failure, const Body& body) {
    if (setjmp(failure.out)) return false;
    body();
    return true;
}

}  // namespace slim
