#pragma once

#include "slim/base/error.h"

#include <string>
#include <utility>

namespace slim {

/// What another process failed with, whose text is for a person as it is; its parts go on to a
/// program that reads our --json.
struct ToldError : Error {
    ToldError(ExitCode code, const std::string& text, Fault its_parts)
        : Error(code, text), parts(std::move(its_parts)) {}
    Fault parts;  ///< without a problem, which is in the text
};

}  // namespace slim
