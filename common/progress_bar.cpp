#include <cstdio>
#include <holdfast/common/progress_bar.hpp>

namespace holdfast::common {

void ProgressBar::begin(const std::string& what) {
  what_ = what;
  draw(what_);
}

void ProgressBar::clear() {
  if (shown_) terminal_.err << "\r\033[K" << std::flush;
  shown_ = false;
}

std::function<bool(const Iteration&)> ProgressBar::callback() {
  if (!terminal_.interactive) return {};
  return [this](const Iteration& iteration) {
    char text[80];
    std::snprintf(text, sizeof text, ": iteration %d, cost %.6g", iteration.number, iteration.cost);
    draw(what_ + text);
    return true;
  };
}

void ProgressBar::draw(const std::string& text) {
  constexpr std::size_t kWidth = 24;
  if (!terminal_.interactive || watch_.seconds() < next_draw_) return;
  next_draw_ = watch_.seconds() + 0.1;
  const std::size_t full = total_ == 0 ? 0 : kWidth * done_ / total_;
  terminal_.err << "\r\033[K[" << std::string(full, '#') << std::string(kWidth - full, '.') << "] " << done_ << '/' << total_ << ' ' << text
                << std::flush;
  shown_ = true;
}

}  // namespace holdfast::common
