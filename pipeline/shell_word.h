#pragma once

#include <string>
#include <vector>

namespace slim {

/// The text as one word of a POSIX shell, in single quotes whatever it is.
std::string shell_quoted(const std::string& text);

/// The same without quotes where no character needs them: for commands that people read and paste.
std::string shell_word(const std::string& text);

/// Such words with blanks between them; of "--title=a b" only the value is quoted.
std::string shell_line(const std::vector<std::string>& words);

}  // namespace slim
