// SPDX-License-Identifier: BSD-3-Clause
// Runs jobs in FMI4j: java -cp 'JARS/*' RunFmi4j.java JOBS.json FOUND.json
import com.fasterxml.jackson.databind.JsonNode;
import com.fasterxml.jackson.databind.ObjectMapper;
import com.fasterxml.jackson.databind.node.ArrayNode;
import com.fasterxml.jackson.databind.node.ObjectNode;
import java.io.File;
import java.util.ArrayList;
import java.util.List;
import java.util.Map;
import no.ntnu.ihb.fmi4j.FmiStatus;
import no.ntnu.ihb.fmi4j.SlaveInstance;
import no.ntnu.ihb.fmi4j.importer.AbstractFmu;

class RunFmi4j {
    static void expect(boolean fine, JsonNode job, String what) {
        if (!fine) throw new IllegalStateException(job.get("title").asText() + ": " + what);
    }

    static long[] references(JsonNode job, Iterable<String> names) {
        List<Long> found = new ArrayList<>();
        for (String name : names) found.add(job.get("references").get(name).asLong());
        return found.stream().mapToLong(Long::longValue).toArray();
    }

    static void set(SlaveInstance slave, JsonNode job) {
        for (Map.Entry<String, JsonNode> e : job.get("integers").properties()) {
            long[] reference = references(job, List.of(e.getKey()));
            expect(slave.writeInteger(reference, new int[] {e.getValue().asInt()}) == FmiStatus.OK, job, e.getKey());
        }
        for (Map.Entry<String, JsonNode> e : job.get("reals").properties()) {
            long[] reference = references(job, List.of(e.getKey()));
            expect(slave.writeReal(reference, new double[] {e.getValue().asDouble()}) == FmiStatus.OK, job, e.getKey());
        }
    }

    static void run(JsonNode job, ArrayNode rows) throws Exception {
        try (AbstractFmu fmu = AbstractFmu.from(new File(job.get("fmu").asText()))) {
            SlaveInstance slave = fmu.asCoSimulationFmu().newInstance("plant");
            expect(slave.setupExperiment(), job, "setup");
            expect(slave.enterInitializationMode(), job, "initialization");
            set(slave, job);
            expect(slave.exitInitializationMode(), job, "initialization");
            List<String> outputs = new ArrayList<>();
            for (JsonNode name : job.get("outputs")) outputs.add(name.asText());
            long[] references = references(job, outputs);
            double[] values = new double[references.length];
            double step = job.get("step").asDouble();
            for (int k = 0; k < job.get("steps").asInt(); ++k) {
                expect(slave.doStep(k * step, step), job, "step " + k);
                expect(slave.readReal(references, values) == FmiStatus.OK, job, "outputs");
                ArrayNode row = rows.addArray();
                for (double value : values) row.add(value);
            }
            expect(slave.terminate(), job, "the end");
        }
    }

    public static void main(String[] arguments) throws Exception {
        ObjectMapper json = new ObjectMapper();
        ObjectNode found = json.createObjectNode();
        for (JsonNode job : json.readTree(new File(arguments[0]))) run(job, found.putArray(job.get("title").asText()));
        json.writeValue(new File(arguments[1]), found);
    }
}
