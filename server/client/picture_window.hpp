// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <SDL.h>
#include <SDL_ttf.h>

#include <cstdint>
#include <memory>
#include <string>

#include "proto/base/result.hpp"
#include "proto/model/picture_size.hpp"
#include "server/client/display_state.hpp"

namespace fanlight {

/// A window with the picture, the word for its state above it, and lines of text. Main thread only.
class PictureWindow {
 public:
  struct Texts {
    DisplayState::Condition condition;
    std::string title;   ///< what is shown
    std::string reach;   ///< "Sent outside" where displays beyond the room show it too
    std::string hint;    ///< the keys, or what was refused
    std::string on_bar;  ///< such as which volume of the cine is on show
    bool hint_is_refusal = false;
  };

  /// Errors: kUnavailable: there is no screen, or no font.
  static Result<std::unique_ptr<PictureWindow>> open(const std::string& name, bool full_screen);
  ~PictureWindow();
  PictureWindow(const PictureWindow&) = delete;
  PictureWindow& operator=(const PictureWindow&) = delete;

  /// Takes a JPEG picture. Error, kInvalidArgument: it is none.
  Result<void> take_jpeg(const std::string& jpeg);
  /// Shows no picture until the next one.
  void forget_picture();

  /// Draws the newest picture, as large as it fits, and the texts. A picture that is lost is dimmed.
  void draw(const Texts& texts);

  /// The pixel of the picture, in `width` x `height` pixels, under a point of the window.
  SDL_FPoint picture_point(int x, int y, double width, double height) const;
  /// Pixels of a picture of this height for each pixel of the window.
  double pixels_per_point(double height) const;

  /// Pixels of the screen for the largest picture that fits.
  PictureSize pixel_size() const;

  void toggle_full_screen();
  void leave_full_screen();

 private:
  PictureWindow() = default;
  Result<void> start(const std::string& name, bool full_screen);
  Result<TTF_Font*> open_font(int points);
  /// Returns the width drawn. `right`: `x` is its right edge.
  int draw_text(TTF_Font* font, const std::string& text, int x, int y, SDL_Color colour, bool right = false);
  void draw_sign(DisplayState::Word word, int x, int y, int size);

  bool has_fonts_ = false;
  SDL_Window* window_ = nullptr;
  SDL_Renderer* renderer_ = nullptr;
  SDL_Texture* texture_ = nullptr;
  TTF_Font* bold_ = nullptr;
  TTF_Font* small_ = nullptr;
  int width_ = 0;  // of the picture
  int height_ = 0;
  SDL_Rect shown_{};  // where it is in the window
};

}  // namespace fanlight
