package vantage.spy;

import bot_core.image_t;
import lcm.spy.SpyPlugin;

/** Shows CAMERA_IMAGE with the detected features over it. */
public final class CameraImagePlugin extends ViewPlugin implements SpyPlugin {
  public CameraImagePlugin() {
    super(image_t.LCM_FINGERPRINT, "Camera view");
  }

  @Override
  View open(String channel) {
    return new CameraImageView(channel);
  }
}
