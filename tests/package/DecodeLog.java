// SPDX-License-Identifier: BSD-3-Clause
import java.util.TreeMap;
import lcm.logging.Log;
import lcm.spy.LCMTypeDatabase;

/** Decodes every message of an LCM log as lcm-spy does: by the fingerprint, with classes that it finds on CLASSPATH. */
public final class DecodeLog {
    public static void main(String[] arguments) throws Exception {
        final LCMTypeDatabase types = new LCMTypeDatabase();
        final TreeMap<String, String> found = new TreeMap<>();
        final Log log = new Log(arguments[0], "r");
        try {
            while (true) {
                final Log.Event event = log.readNext();
                final long fingerprint = java.nio.ByteBuffer.wrap(event.data).getLong();
                final Class<?> type = types.getClassByFingerprint(fingerprint);
                if (type == null) throw new Exception("no type for a message on " + event.channel);
                final Object message = type.getConstructor(byte[].class).newInstance((Object) event.data);
                String text = type.getSimpleName();
                if (text.equals("status_t")) text += " " + type.getField("process").get(message);
                found.put(event.channel, text);
            }
        } catch (java.io.EOFException end) {
            found.forEach((channel, text) -> System.out.println(channel + " " + text));
        }
    }
}
