// SPDX-License-Identifier: GPL-2.0-or-later
// Bytes that arrive from a connection, and the lines in them. It holds little more than one line of the
// greatest length: a longer one is dropped as it arrives.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace plumb::host {

class LineBuffer {
public:
    static constexpr std::size_t longest = 1 << 20;  // bytes of a line
    static constexpr std::size_t piece = 1 << 16;    // bytes to append at once, at most

    enum class Next { nothing, line, too_long };

    void append(std::string_view bytes) {
        if (!dropping_) {
            text_ += bytes;
            return;
        }
        const std::size_t end = bytes.find('\n');
        if (end == std::string_view::npos) return;
        dropping_ = false;
        dropped_ = true;
        text_ = bytes.substr(end + 1);
    }

    // Whether a line is to be taken before more is appended.
    bool full() const { return waiting().size() > longest || dropped_; }

    // The state of the next line.
    Next next() {
        if (dropped_) return Next::too_long;
        const std::size_t end = text_.find('\n', searched_);
        if (end == std::string::npos) {
            searched_ = text_.size();
            if (waiting().size() <= longest) return Next::nothing;
            forget();
            dropping_ = true;
            return Next::nothing;
        }
        searched_ = end;  // found at once when it is looked for again
        return end - begin_ > longest ? Next::too_long : Next::line;
    }

    // The line that next() has announced, without its end; nothing of one that is too long.
    std::string take() {
        if (dropped_) {
            dropped_ = false;
            return "";
        }
        const std::size_t size = searched_ - begin_;
        std::string line = size > longest ? "" : text_.substr(begin_, size);
        begin_ = ++searched_;
        if (begin_ == text_.size()) {
            forget();
        } else if (begin_ > longest) {  // so that each byte is moved but once
            text_.erase(0, begin_);
            begin_ = searched_ = 0;
        }
        return line;
    }

    // A copy of that line, which stays.
    std::string look() const { return dropped_ ? "" : text_.substr(begin_, searched_ - begin_); }

    // All that has arrived and is not taken.
    std::string_view waiting() const { return std::string_view(text_).substr(begin_); }

private:
    void forget() {
        text_.clear();
        begin_ = searched_ = 0;
    }

    std::string text_;
    std::size_t begin_ = 0;     // of the bytes that are not taken
    std::size_t searched_ = 0;  // before it no line ends
    bool dropping_ = false;     // of a line that is too long more arrives
    bool dropped_ = false;      // such a line has ended
};

}  // namespace plumb::host
