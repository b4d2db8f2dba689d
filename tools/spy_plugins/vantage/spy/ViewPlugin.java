package vantage.spy;

import java.awt.event.ActionEvent;
import java.awt.event.WindowAdapter;
import java.awt.event.WindowEvent;
import javax.swing.AbstractAction;
import javax.swing.Action;
import javax.swing.JComponent;
import javax.swing.JDesktopPane;
import javax.swing.JFrame;
import javax.swing.WindowConstants;
import lcm.lcm.LCM;
import lcm.spy.ChannelData;

/**
 * A plugin of lcm-spy that opens a window on one channel: right-click the channel's row. Subclasses name
 * SpyPlugin as their own interface and have a constructor without arguments: that is how lcm-spy finds them.
 */
abstract class ViewPlugin {
  /** What a window shows; it subscribes by itself. */
  abstract static class View extends JComponent {
    abstract void start(LCM lcm);

    abstract void stop(LCM lcm);
  }

  private final long fingerprint;
  private final String title;

  ViewPlugin(long fingerprint, String title) {
    this.fingerprint = fingerprint;
    this.title = title;
  }

  abstract View open(String channel);

  public boolean canHandle(long fingerprint) {
    return fingerprint == this.fingerprint;
  }

  // Of the desktop there is none in today's lcm-spy, whose windows are the system's.
  public Action getAction(JDesktopPane desktop, ChannelData channel) {
    return new AbstractAction(title) {
      @Override
      public void actionPerformed(ActionEvent event) {
        show(channel.name);
      }
    };
  }

  private void show(String channel) {
    View view = open(channel);
    LCM lcm = LCM.getSingleton();
    JFrame frame = new JFrame(title + ": " + channel);
    frame.setDefaultCloseOperation(WindowConstants.DISPOSE_ON_CLOSE);
    frame.add(view);
    frame.pack();
    frame.addWindowListener(
        new WindowAdapter() {
          @Override
          public void windowClosed(WindowEvent event) {
            view.stop(lcm);
          }
        });
    frame.setLocationByPlatform(true);
    frame.setVisible(true);
    view.start(lcm);
  }

  /** Name of another channel of the same prefix: "LEFT_CAMERA_IMAGE" and "IMAGE_FEATURES". */
  static String sibling(String channel, String suffix, String other) {
    return channel.endsWith(suffix)
        ? channel.substring(0, channel.length() - suffix.length()) + other
        : other;
  }
}
