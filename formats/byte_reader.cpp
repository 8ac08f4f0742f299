#include "formats/byte_reader.h"

#include "formats/message.h"
#include "slim/base/error.h"

#include <zlib.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace slim {
namespace {

constexpr std::size_t kBufferSize = std::size_t{1} << 20;
constexpr std::size_t kLongestLine = std::size_t{16} << 20;

}  // namespace

struct ByteReader::Inflater {
    z_stream stream{};
    std::vector<char> packed = std::vector<char>(std::size_t{1} << 17);
    bool at_member_end = false;

    Inflater() {
        // 15 + 16: the largest window, gzip framing only.
        if (inflateInit2(&stream, 15 + 16) != Z_OK) throw ResourceError("zlib: out of memory");
    }
    ~Inflater() { inflateEnd(&stream); }
    Inflater(const Inflater&) = delete;
    Inflater& operator=(const Inflater&) = delete;
};

ByteReader::ByteReader(const std::string& path) : path_(path) {
    struct stat status {};
    if (::stat(path.c_str(), &status) != 0)
        throw IoError(
            {.file = path,
             .problem = message("cannot be opened: ", std::strerror(errno)),
             .hint = path == "-" ? "standard input is not read: clouds are read more than once"
                                 : ""});
    if (!S_ISREG(status.st_mode))
        throw IoError({.file = path,
                       .problem = S_ISDIR(status.st_mode)
                                      ? "is a folder; expected a cloud's file in it"
                                      : "is not a regular file; clouds are read more than once"});
    file_ = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
    if (file_ < 0)
        throw IoError(
            {.file = path, .problem = message("cannot be opened: ", std::strerror(errno))});
    file_size_ = static_cast<std::uint64_t>(status.st_size);
    try {
        buffer_.resize(kBufferSize);
        const std::string_view magic = peek(2);
        if (magic.size() >= 2 && magic[0] == '\x1f' && magic[1] == '\x8b') {
            inflater_ = std::make_unique<Inflater>();
            begin_ = end_ = 0;
            file_offset_ = 0;
        }
        find_line_end();
    } catch (...) {
        ::close(file_);
        throw;
    }
}

ByteReader::~ByteReader() { ::close(file_); }

std::size_t ByteReader::read_file(char* out, std::size_t n) {
    for (;;) {
        const ssize_t got = ::pread(file_, out, n, static_cast<off_t>(file_offset_));
        if (got < 0 && errno == EINTR) continue;
        if (got < 0)
            throw IoError(message(path_, ": byte ", file_offset_, ": cannot be read: ",
                                  std::strerror(errno)));
        file_offset_ += static_cast<std::uint64_t>(got);
        return static_cast<std::size_t>(got);
    }
}

std::size_t ByteReader::inflate_some(char* out, std::size_t n) {
    z_stream& z = inflater_->stream;
    z.next_out = reinterpret_cast<Bytef*>(out);
    z.avail_out = static_cast<uInt>(std::min<std::size_t>(n, 1u << 30));
    const uInt room = z.avail_out;
    while (z.avail_out == room) {
        if (z.avail_in == 0) {
            const std::size_t got = read_file(inflater_->packed.data(), inflater_->packed.size());
            if (got == 0 && inflater_->at_member_end) return 0;
            if (got == 0)
                throw FormatError(message(path_, ": byte ", file_offset_,
                                          ": the gzip stream ends before its end mark"));
            z.next_in = reinterpret_cast<Bytef*>(inflater_->packed.data());
            z.avail_in = static_cast<uInt>(got);
        }
        // Another member may follow (cat a.gz b.gz); zeros behind the last one are padding.
        if (inflater_->at_member_end) {
            if (*z.next_in == 0) {
                z.avail_in = 0;
                continue;
            }
            inflateReset(&z);
            inflater_->at_member_end = false;
        }
        const int status = inflate(&z, Z_NO_FLUSH);
        if (status == Z_STREAM_END) inflater_->at_member_end = true;
        else if (status != Z_OK && status != Z_BUF_ERROR)
            throw FormatError(message(path_, ": near byte ", file_offset_ - z.avail_in,
                                      ": damaged gzip stream (", z.msg ? z.msg : "zlib error",
                                      ")"));
    }
    return room - z.avail_out;
}

bool ByteReader::refill() {
    if (begin_ > 0) {
        std::memmove(buffer_.data(), buffer_.data() + begin_, end_ - begin_);
        base_ += begin_;
        end_ -= begin_;
        begin_ = 0;
    }
    if (end_ == buffer_.size()) buffer_.resize(buffer_.size() * 2);
    char* out = buffer_.data() + end_;
    const std::size_t room = buffer_.size() - end_;
    const std::size_t got = inflater_ ? inflate_some(out, room) : read_file(out, room);
    end_ += got;
    return got > 0;
}

std::string_view ByteReader::peek(std::size_t wanted) {
    while (end_ - begin_ < wanted && refill()) {
    }
    return {buffer_.data() + begin_, end_ - begin_};
}

bool ByteReader::skip(std::uint64_t n) {
    const std::uint64_t buffered = std::min<std::uint64_t>(n, end_ - begin_);
    begin_ += static_cast<std::size_t>(buffered);
    n -= buffered;
    if (n == 0) return true;
    if (!inflater_) {
        if (n > file_size_ - std::min(file_size_, file_offset_)) return false;
        base_ += begin_ + n;
        begin_ = end_ = 0;
        file_offset_ += n;
        return true;
    }
    while (n > 0) {
        const std::string_view view = peek(1);
        if (view.empty()) return false;
        const std::uint64_t step = std::min<std::uint64_t>(n, view.size());
        advance(static_cast<std::size_t>(step));
        n -= step;
    }
    return true;
}

/// The first line end of the file decides; only a file whose first is a lone CR is cut at CRs.
void ByteReader::find_line_end() {
    const std::string_view view = peek(4096);
    const auto at = view.find_first_of("\r\n");
    if (at == std::string_view::npos || view[at] == '\n') return;
    if (at + 1 < view.size() && view[at + 1] != '\n') line_end_ = '\r';
}

bool ByteReader::skip_byte_order_mark() {
    if (!peek(kByteOrderMark.size()).starts_with(kByteOrderMark)) return false;
    advance(kByteOrderMark.size());
    return true;
}

bool ByteReader::read_line(std::string_view& line) {
    std::size_t searched = 0;
    for (;;) {
        const char* from = buffer_.data() + begin_;
        const std::size_t size = end_ - begin_;
        const void* hit =
            size > searched ? std::memchr(from + searched, line_end_, size - searched) : nullptr;
        std::size_t length =
            hit ? static_cast<std::size_t>(static_cast<const char*>(hit) - from) : size;
        if (length > kLongestLine)
            throw FormatError(message(path_, ": line ", line_number_ + 1, ": longer than ",
                                      kLongestLine >> 20, " MiB; this is not text"));
        if (!hit) {
            searched = size;
            if (refill()) continue;
            if (size == 0) return false;
        }
        begin_ += length + (hit ? 1 : 0);
        ++line_number_;
        from = buffer_.data() + begin_ - length - (hit ? 1 : 0);
        if (length > 0 && from[length - 1] == '\r') --length;
        line = {from, length};
        return true;
    }
}

std::optional<std::uint64_t> ByteReader::remaining() const {
    if (inflater_) return std::nullopt;
    return file_size_ - std::min(file_size_, offset());
}

}  // namespace slim
